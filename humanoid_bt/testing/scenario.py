"""Scenario files: a tree in a scene, what happens to it, and what is expected of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from humanoid_bt.core.errors import Place, Problem, UserError
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import Param, param, params_of
from humanoid_bt.core.reading import convert, read
from humanoid_bt.core.sources import Sources
from humanoid_bt.files import document
from humanoid_bt.files.reading import is_file
from humanoid_bt.files.workspace import is_path
from humanoid_bt.testing.conditions import Conditions
from humanoid_bt.testing.events import Event, too_late
from humanoid_bt.testing.expectation import Within
from humanoid_bt.testing.expectations import Expectations
from humanoid_bt.testing.seeds import Seeds
from humanoid_bt.testing.substitution import Replacement


@dataclass(frozen=True)
class Values:
    """Values for a tree's parameters, with the places where they are written.

    Attributes:
        items: them by name.
    """

    items: Mapping[str, Item]

    described = "mapping of values"

    @classmethod
    def from_item(cls, item: Item, name: str) -> Values:
        """Read a mapping; raises UserError."""
        if not isinstance(item.value, dict):
            hint = "like {stop_distance: 35 cm}"
            raise UserError(f"{name!r} must be a mapping, not {item.kind}", item.place, hint, "wrong-type")
        return cls(item.value)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A scenario. Angles [rad], lengths [m], times [s], world frame, from ``scenarios/*.yaml``."""

    format: int = param(doc="Version of this file's form: 1.", minimum=1, maximum=1)
    description: str = param("", doc="One line for people.")
    tree: str = param(doc="The tree, by name or path.")
    robot: str | None = param(None, doc="The robot; what the tree says if not given.")
    scene: str | None = param(None, doc="The scene; what the tree says if not given.")
    perception: Sources | None = param(None, doc="The percept sources; what the tree or the scene says if not given.")
    seeds: Seeds = param(Seeds(), doc="A run for each: 3, 0-9, '0-9, 20' or [0, 4, 7].")
    duration: float = param(60.0, above=0, unit="s", doc="Longest simulated time of a run.")
    dry: bool = param(False, doc="Without physics: the robot is at once where it is told to be.")
    parameters: Values = param(Values({}), doc="Values for the tree's parameters, by name.")
    conditions: Conditions = param(Conditions(), doc="What is different from the beginning.")
    script: list[Event] = param([], doc="What happens, each at a time or when something becomes true.")
    replace: dict[str, Replacement] = param(
        {}, doc="What stands in a node's place, by its path, the end of it, or type."
    )
    expect: Expectations = param(doc="What must be true of every run, and when.")
    path: Path = field(default=Path(), compare=False)
    item: Item = field(default=Item({}, Place("")), compare=False, repr=False)

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what does not go together."""
        duration = values.get("duration", 60.0)
        for one in values.get("expect", ()):
            if isinstance(one, Within) and one.limit > duration:
                message = f"a run ends after {duration:g} s, before {one.limit:g} s are over"
                yield Problem(message, one.place, f"duration: {one.limit:g} s", "out-of-range")
        yield from too_late(values.get("script", ()), duration)

    @property
    def name(self) -> str:
        """Its file's name."""
        return self.path.stem

    def place(self, *keys: str) -> Place:
        """Return where a value is written, or what stands around it where it is not."""
        return self.item.place_of(*keys)


def load_scenario(path: Path) -> Scenario:
    """Read a scenario file, without the tree that it names.

    Raises:
        UserError: with every problem found, each with its place.
    """
    item = document.load(path)
    scenario: Scenario = read(Scenario, item, "the scenario")
    return _located(scenario, path, item)


def readable_scenario(path: Path) -> Scenario | None:
    """Read of a scenario file with mistakes what can be read, so that the rest can be checked, too.

    Returns:
        It without the values and items that have mistakes; None if it names no tree.

    Raises:
        UserError: the file is no YAML.
    """
    item = document.load(path)
    values: dict[str, Any] = {"format": 1, "expect": Expectations(())}
    for name, spec in params_of(Scenario).items() if isinstance(item.value, dict) else ():
        if name in item.value:
            with suppress(UserError):
                values[name] = convert(spec, _readable(spec, item.value[name]))
    return _located(Scenario(**values), path, item) if "tree" in values else None


def _readable(spec: Param, item: Item) -> Item:
    """Return a value without those of its items that cannot be read."""
    if isinstance(item.value, list):
        return replace(item, value=[part for part in item.value if _reads(spec, replace(item, value=[part]))])
    if isinstance(item.value, dict):
        parts = {key: replace(item, value={key: part}) for key, part in item.value.items()}
        return replace(item, value={key: item.value[key] for key, part in parts.items() if _reads(spec, part)})
    return item


def _reads(spec: Param, item: Item) -> bool:
    try:
        convert(spec, item)
    except UserError:
        return False
    return True


def _located(scenario: Scenario, path: Path, item: Item) -> Scenario:
    """Return a scenario with its file, and with the files that it names beside that."""
    beside: dict[str, Any] = {key: _file(path, getattr(scenario, key)) for key in ("tree", "robot", "scene")}
    beside["replace"] = {name: _beside(path, stand_in) for name, stand_in in scenario.replace.items()}
    return replace(scenario, **beside, path=path, item=item)


def _file(path: Path, name: str | None) -> str | None:
    """Return the file, or folder of a robot, that a path in a scenario names beside its file, else the name."""
    if name is None or not is_path(name):
        return name
    beside = path.parent / name
    return str(beside) if is_file(beside) or is_file(beside / "robot.yaml") else name


def _beside(path: Path, stand_in: Replacement) -> Replacement:
    """Return a stand-in whose recording is looked for beside the scenario's file."""
    if stand_in.recorded is None:
        return stand_in
    return replace(stand_in, recorded=path.parent / stand_in.recorded)
