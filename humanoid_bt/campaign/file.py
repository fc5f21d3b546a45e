"""Campaign files: what is to be tried, how often, and what has to come of it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

from humanoid_bt.campaign.variation import Variation
from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import param, params_of
from humanoid_bt.core.reading import read
from humanoid_bt.core.sources import Sources
from humanoid_bt.files import document
from humanoid_bt.testing.conditions import Conditions
from humanoid_bt.testing.events import Event, too_late
from humanoid_bt.testing.seeds import Seeds
from humanoid_bt.tree.expressions.expression import Truth

FOLDER = "campaigns"
"""Folder of a workspace in which campaign files are."""

TIME_LIMIT = 300.0
"""Time on the wall clock after which a trial hangs, where nothing else is said [s]."""

RECORDINGS = 3
"""How many failures of each cause are recorded where nothing else is said."""

_NAMED = {"type": "string"}
_NAME = re.compile(r"\w[\w .-]{0,99}")
_NO_NAME = re.compile(r"[^\w .-]|^[ .-]")


@dataclass(frozen=True)
class Names:
    """Names or files of trees, robots or scenes, with their places."""

    items: tuple[Item, ...] = ()

    described: ClassVar[str] = "name, or list of names"
    """What they are called in messages."""

    schema: ClassVar[Mapping[str, Any]] = {"anyOf": [_NAMED, {"type": "array", "items": _NAMED, "minItems": 1}]}
    """How they are written, for editors."""

    @classmethod
    def from_item(cls, item: Item, name: str) -> Names:
        """Read a name, or a list of names.

        Raises:
            UserError: it is neither.
        """
        parts = item.value if isinstance(item.value, list) else [item]
        for part in parts:
            if not isinstance(part.value, str):
                raise UserError(f"{name!r} must be a {cls.described}, not {part.kind}", part.place, code="wrong-type")
        if not parts or len({part.value for part in parts}) < len(parts):
            raise UserError(f"{name!r} needs names, none of them twice", item.place, code="wrong-length")
        return cls(tuple(parts))


@dataclass(frozen=True, kw_only=True)
class PushVariation:
    """A push of the torso, once in every trial."""

    at: Variation = param(unit="s", minimum=0, doc="When, on the engine's clock.")
    force: Variation = param(unit="N", minimum=0, maximum=10_000, doc="How hard, horizontally.")
    direction: Variation = param(Variation(), unit="rad", doc="Where to; 0 is the world's x, left is positive.")
    duration: Variation = param(Variation(), unit="s", above=0, doc="How long; 0.1 s if not given.")


@dataclass(frozen=True, kw_only=True)
class CampaignFile:
    """A campaign. What varies is a value, a list of values that are all tried, or LOW .. HIGH, drawn for each trial."""

    format: int = param(doc="Version of this file's form: 1.", minimum=1, maximum=1)
    name: str = param(doc="The campaign's name.")
    description: str = param("", doc="One line for people.")
    tree: Names = param(doc="Name or file of the tree; several are all tried.")
    robot: Names = param(Names(), doc="The robots; what the tree says if not given.")
    scene: Names = param(Names(), doc="The scenes; what the tree says if not given.")
    perception: Sources | None = param(None, doc="The percept sources; what the tree or the scene says if not given.")
    seeds: Seeds = param(Seeds(tuple(range(100))), doc="Each is tried with everything else: 0-99, or 3, 17, 100-199.")
    parameters: dict[str, Variation] = param({}, doc="Parameters of the tree, each of which may vary.")
    conditions: dict[str, Variation] = param({}, doc="What is different from the robot's and the scene's files.")
    pushes: list[PushVariation] = param([], doc="Pushes, each once in every trial.")
    script: list[Event] = param([], doc="What happens in every trial: faults, each at a moment.")
    duration: float | None = param(
        None, unit="s", above=0, doc="Longest simulated time of a trial; as a run's if not given."
    )
    time_limit: float = param(TIME_LIMIT, unit="s", above=0, doc="Time on the wall clock after which a trial hangs.")
    dry: bool = param(False, doc="Without physics, for the logic of the tree alone.")
    fail_on: list[Literal["fell", "bumped", "stopped"]] = param(
        [], doc="What makes a trial a failure whose tree succeeded: the robot fell, bumped into something, was stopped."
    )
    recordings: int = param(RECORDINGS, minimum=0, doc="How many failures of each cause are recorded and explained.")
    require: list[Truth] = param([], doc="What has to come of it: success >= 95 %.")

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what cannot be read without knowing the trees."""
        for name, place in _places(item, "conditions"):
            if name not in (known := params_of(Conditions)):
                hint = f"valid: {', '.join(known)}"
                yield Problem(f"there is no condition {name!r}", place, hint, "unknown-key")
        yield from too_late(values.get("script", ()), values.get("duration") or math.inf)
        if values.get("dry") and (physical := sorted({"bumped", "fell"} & set(values.get("fail_on", ())))):
            hint = "run it without dry, or leave it out"
            message = f"fail_on {physical[0]!r} needs a body, and a dry run simulates none"
            yield Problem(message, item.value["fail_on"].place, hint, "out-of-range")
        if "name" in values and not _NAME.fullmatch(values["name"]):
            hint = "letters, digits, blanks, _, - and ., for it names a folder"
            yield Problem(f"{values['name']!r} cannot be a name", item.value["name"].place, hint, "bad-name")


def named_after(tree: Path) -> str:
    """Return a name for the campaign of a tree alone, whatever its file is called."""
    return _NO_NAME.sub("_", tree.stem)[:100]


def load_campaign(path: Path) -> CampaignFile:
    """Read a campaign file.

    Raises:
        UserError: with every problem found, each with its place.
    """
    campaign: CampaignFile = read(CampaignFile, document.load(path), "the campaign")
    return campaign


def _places(item: Item, key: str) -> Iterator[tuple[str, Any]]:
    """Yield the keys of a mapping in a file, each with its place."""
    part = item.value.get(key)
    if part is not None and isinstance(part.value, dict):
        yield from part.key_places.items()
