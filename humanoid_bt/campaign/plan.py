"""What a campaign runs: the trials, in their order, and all that they follow from."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from humanoid_bt.campaign.trial import Trial
from humanoid_bt.campaign.variation import Factor
from humanoid_bt.core.errors import UserError
from humanoid_bt.perception.choice import written
from humanoid_bt.testing.seeds import Seeds

MOST = 1_000_000
"""Most trials of a campaign."""


class Setting(NamedTuple):
    """A tree on a robot in a scene: names or files."""

    tree: str
    robot: str
    scene: str


@dataclass(frozen=True)
class Plan:
    """What a campaign runs.

    Attributes:
        name: of the campaign.
        settings: every tree on every robot in every scene.
        seeds: that each of them is tried with.
        factors: what trials are given beside.
        duration: longest simulated time of a trial [s]; None for what a run has.
        dry: whether there is no physics.
        perception: the percept sources as they are written; None for what each tree or its scene says.
        script: what happens in every trial, as its file has it.
        fail_on: what makes a trial a failure that else would have succeeded.
        description: one line for people.
        files: digest of each file that what is run depends on, by path.
        workspace: the folder where names are looked up, "" for the working directory.
    """

    name: str
    settings: tuple[Setting, ...]
    seeds: Seeds
    factors: tuple[Factor, ...] = ()
    duration: float | None = None
    dry: bool = False
    perception: Any = None
    script: tuple[Mapping[str, Any], ...] = ()
    fail_on: tuple[str, ...] = ()
    description: str = ""
    files: Mapping[str, str] = field(default_factory=dict)
    workspace: str = ""

    def __post_init__(self) -> None:
        if len(self) > MOST:
            raise UserError(f"these are {len(self):,} trials, and a campaign has {MOST:,} at most")

    def __len__(self) -> int:
        number = len(self.seeds) * len(self.settings)
        for factor in self.factors:
            number *= len(factor.levels)
        return number

    @cached_property
    def trials(self) -> tuple[Trial, ...]:
        """Every trial; all of a seed come together, so that half of a campaign is half of each of its parts."""
        levels = [[(factor, level) for level in factor.levels] for factor in self.factors]
        cells = itertools.product(self.seeds, self.settings, itertools.product(*levels))
        return tuple(
            Trial(
                number=number,
                **setting._asdict(),
                seed=seed,
                given={factor.name: factor.value(level, seed) for factor, level in given},
                duration=self.duration,
                dry=self.dry,
            )
            for number, (seed, setting, given) in enumerate(cells)
        )

    @property
    def varies(self) -> tuple[str, ...]:
        """The columns in which trials differ beside their seed."""
        parts = [name for name in Setting._fields if len({getattr(one, name) for one in self.settings}) > 1]
        return (*parts, *(factor.name for factor in self.factors if factor.varies))

    @property
    def sources(self) -> list[str]:
        """The percept sources, each as the command line takes it; none where trees and scenes say which."""
        named = written(self.perception)
        return named.texts if named else []

    @property
    def title(self) -> str:
        """What is run, in a line."""
        many = {name: sorted({getattr(one, name) for one in self.settings}) for name in Setting._fields}
        tree, robot, scene = (names[0] if len(names) == 1 else f"{len(names)} {what}s" for what, names in many.items())
        dry = ", dry: without physics" if self.dry else ""
        seen = f", perception {', '.join(self.sources)}" if self.sources else ""
        return f"{tree} on {robot} in {scene}, seeds {self.seeds}{seen}{dry}"

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return {**asdict(self), "settings": [list(setting) for setting in self.settings], "seeds": str(self.seeds)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Plan:
        """Return what :meth:`to_dict` was made of.

        Raises:
            LookupError, TypeError, ValueError: of nothing.
        """
        factors = (
            Factor(**{**factor, "values": tuple(factor["values"]), "ends": factor["ends"] and tuple(factor["ends"])})
            for factor in data["factors"]
        )
        made = {
            "settings": tuple(Setting(*setting) for setting in data["settings"]),
            "seeds": Seeds.parse(data["seeds"]),
            "factors": tuple(factors),
            "script": tuple(data["script"]),
            "fail_on": tuple(data.get("fail_on", ())),
        }
        return cls(**{**data, **made})
