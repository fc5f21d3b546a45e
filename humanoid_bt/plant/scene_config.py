"""Scene files: where the robot starts, what stands around it, what perception sees of it, and what happens when."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from humanoid_bt.core.errors import Problem, UserError, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.core.messages import SIGHT, WORKSPACE
from humanoid_bt.core.params import param, params_of
from humanoid_bt.core.reading import read, unexplained
from humanoid_bt.core.sources import Sources
from humanoid_bt.files import document

Shape = Literal["ball", "box", "cylinder", "person"]
Color = Literal["red", "orange", "yellow", "green", "blue", "purple", "white", "grey", "black"]

ACTIONS = ("hide", "show", "move")
"""What an event can be."""

MAX_THINGS = 1000
"""Most objects, and most percepts, of a scene."""

_FARTHEST = 0.9 * (WORKSPACE - SIGHT)  # m from the origin, on each axis: there is room to walk on, and to look beyond
_LONGEST_NAME = 200  # characters
_SIZES: dict[Shape, str] = {
    "ball": "[diameter]",
    "box": "[length, width, height]",
    "cylinder": "[diameter, height]",
    "person": "[height]",
}


@dataclass(frozen=True, kw_only=True)
class StartConfig:
    """Where the robot stands at the beginning."""

    position: tuple[float, float] = param(
        (0.0, 0.0),
        minimum=-_FARTHEST,
        maximum=_FARTHEST,
        unit="m",
        doc="Middle between its feet, x y in the world.",
    )
    heading: float = param(0.0, unit="rad", doc="Where it faces; 0 is the world's x, left is positive.")


@dataclass(frozen=True, kw_only=True)
class RandomPlaceConfig:
    """A place drawn from the seed, each number between a low and a high end."""

    distance: tuple[float, float] = param(
        minimum=0, maximum=50, unit="m", doc="Horizontal distance from the robot's start."
    )
    bearing: tuple[float, float] = param(unit="rad", doc="Direction from the robot's start heading, left positive.")
    height: tuple[float, float] = param(minimum=-_FARTHEST, maximum=_FARTHEST, unit="m", doc="Above the floor.")

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what runs from its high to its low end."""
        for what, (low, high) in values.items():
            if low > high:
                message = f"{what!r} runs from {low:g} down to {high:g}"
                yield Problem(message, item.value[what].place, "give the low end first", code="out-of-range")


@dataclass(frozen=True, kw_only=True)
class ObjectConfig:
    """A thing in the scene; it has either a position or a random one."""

    shape: Shape = param(doc="Its shape; a person looks at where the robot starts.")
    size: list[float] = param(
        minimum=1e-4,
        unit="m",
        doc="Full lengths. Ball: diameter; box: length, width, height; cylinder: diameter, height; person: height.",
    )
    color: Color = param("orange", doc="Its colour; a person's clothes.")
    position: tuple[float, float, float] | None = param(
        None, minimum=-_FARTHEST, maximum=_FARTHEST, unit="m", doc="Its centre in the world, x y z."
    )
    random: RandomPlaceConfig | None = param(None, doc="Draws its centre from the seed.")
    stand: bool = param(False, doc="A thin pole with a flat base stands under it; both can be bumped into.")
    solid: bool = param(
        False,
        doc="The robot bumps into it, sees its size and walks round it; if false it is a marker that a hand may enter.",
    )

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what does not go together."""
        places = _written(item, ("position", "random"))
        if len(places) == 2 or not (places or _misspelt(ObjectConfig, item, ("position", "random"))):
            both = "both a position and a random one" if places else "no position"
            hint = "give it either position: [x, y, z] or random: {distance: ..., bearing: ..., height: ...}"
            yield Problem(f"this object has {both}", item.place, hint, code="exclusive-keys")
        shape, size = values.get("shape"), item.value.get("size")
        if shape and size is not None and isinstance(size.value, list):
            wanted = _SIZES[shape]
            if len(size.value) != wanted.count(",") + 1:
                yield Problem(f"a {shape}'s size is {wanted}", size.place, "full lengths [m]", code="wrong-length")


@dataclass(frozen=True, kw_only=True)
class PerceptConfig:
    """What simulated perception makes of one object, 10 times a second."""

    object: str = param(doc="The object that is seen.")
    noise: float = param(0.003, minimum=0, maximum=10, unit="m", doc="Standard deviation of each coordinate at 0 m.")
    noise_per_meter: float = param(0.004, minimum=0, maximum=1, doc="Growth of that deviation with distance [m/m].")
    range: float = param(4.0, above=0, maximum=SIGHT, unit="m", doc="Farther away it is not seen.")
    field_of_view: float = param(1.745, above=0, maximum=6.2832, unit="rad", doc="Full horizontal angle (100 deg).")
    vertical_field_of_view: float = param(1.396, above=0, maximum=3.1416, unit="rad", doc="Full angle (80 deg).")
    drop_out: float = param(0.02, minimum=0, maximum=1, doc="Probability that an observation publishes nothing.")


@dataclass(frozen=True, kw_only=True)
class EventConfig:
    """Something that happens at a time: exactly one of hide, show and move."""

    at: float = param(minimum=0, unit="s", doc="When, on the engine's clock.")
    hide: str | None = param(None, doc="The object that perception no longer sees; it stays where it is.")
    show: str | None = param(None, doc="The object that perception sees again.")
    move: str | None = param(None, doc="The object that moves; its stand stays.")
    to: tuple[float, float, float] | None = param(
        None, minimum=-_FARTHEST, maximum=_FARTHEST, unit="m", doc="Where its centre moves, in the world."
    )
    over: float = param(0.0, minimum=0, unit="s", doc="How long the move takes; 0 is a jump.")

    @staticmethod
    def mistakes(item: Item, _values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what does not go together."""
        found = _written(item, ACTIONS)
        if len(found) > 1:
            message = f"an event is one of {', '.join(ACTIONS)}, not {' and '.join(found)}"
            yield Problem(message, item.place, "make an event of each, with its own at", code="exclusive-keys")
        elif not found and not _misspelt(EventConfig, item, ACTIONS):
            hint = "write hide: OBJECT, show: OBJECT, or move: OBJECT with to: [x, y, z]"
            yield Problem("this event does nothing", item.place, hint, code="exclusive-keys")
        if "move" in found and not _written(item, ("to",)) and not _misspelt(EventConfig, item, ("to",)):
            yield Problem("a move needs where it goes", item.place, "to: [x, y, z]  # m, in the world", "missing-key")
        for key in ("to", "over"):
            if found and "move" not in found and key in item.value:
                yield Problem(f"{key!r} belongs to a move", item.key_places[key], code="misplaced-key")

    @property
    def object(self) -> str:
        """The object it happens to."""
        return self.hide or self.show or self.move or ""


@dataclass(frozen=True, kw_only=True)
class SceneConfig:
    """A scene. Angles [rad], lengths [m], times [s], world frame, from ``sim/scenes/*.yaml``."""

    format: int = param(doc="Version of this file's form: 1.", minimum=1, maximum=1)
    name: str = param(doc="The scene's name.")
    description: str = param("", doc="One line for people.")
    robot: StartConfig = param(StartConfig(), doc="Where the robot starts.")
    objects: dict[str, ObjectConfig] = param({}, doc="What stands in the scene, by name.")
    percepts: dict[str, PerceptConfig] = param({}, doc="What perception publishes, by the name that trees use.")
    perception: Sources | None = param(None, doc="The percept sources; default: `tracker`, which publishes `percepts`.")
    events: list[EventConfig] = param([], doc="What happens when.")
    path: Path = field(default=Path(), compare=False)

    @property
    def digest(self) -> str:
        """Tells it from other scenes by what stands and happens in it, whatever perception makes of that."""
        return hashlib.sha256(repr((self.robot, self.objects, self.events)).encode()).hexdigest()[:16]


def load_scene(path: Path) -> SceneConfig:
    """Read a scene file.

    Raises:
        UserError: with every problem found, each with its place.
    """
    item = document.load(path)
    problems: list[Problem] = []
    config: SceneConfig | None = None
    try:
        config = read(SceneConfig, item, "the scene")
    except UserError as error:
        problems += error.problems
    problems += [*_unknown_objects(item), *_bad_names(item), *_unseen_solids(item)]
    if config is None or problems:
        raise UserError(problems)
    return dataclasses.replace(config, path=path, percepts=config.percepts | _of_solids(config))


def _of_solids(config: SceneConfig) -> dict[str, PerceptConfig]:
    """Return a percept for each solid object that has none: the robot has to see what it bumps into."""
    seen = {percept.object for percept in config.percepts.values()}
    return {
        name: PerceptConfig(object=name) for name, thing in config.objects.items() if thing.solid and name not in seen
    }


def widest_view(config: SceneConfig) -> tuple[float, float]:
    """Return the angles of view, horizontal and vertical [rad], in which the robot can see anything of a scene."""
    percepts = config.percepts.values() or [PerceptConfig(object="")]
    return max(seen.field_of_view for seen in percepts), max(seen.vertical_field_of_view for seen in percepts)


def _unknown_objects(item: Item) -> Iterator[Problem]:
    """Return what names an object that is not there, whatever else is wrong."""
    parts = item.value if isinstance(item.value, dict) else {}
    objects = _mapping(parts.get("objects"))
    for percept in _mapping(parts.get("percepts")).values():
        yield from _no_object(_mapping(percept).get("object"), objects)
    events = parts.get("events")
    for event in events.value if events is not None and isinstance(events.value, list) else ():
        for action in ACTIONS:
            yield from _no_object(_mapping(event).get(action), objects)


def _bad_names(item: Item) -> Iterator[Problem]:
    """Return what cannot be a name, and what there is too much of."""
    parts = item.value if isinstance(item.value, dict) else {}
    for what in ("objects", "percepts"):
        things = _mapping(parts.get(what))
        for name in things:
            if not name.strip() or not name.isprintable() or len(name) > _LONGEST_NAME:
                hint = f"one line of text, of at most {_LONGEST_NAME} characters"
                shown = name if len(name) <= _LONGEST_NAME else f"{name[:20]}..."
                yield Problem(f"{shown!r} cannot be a name", parts[what].key_places[name], hint, code="bad-name")
        if len(things) > MAX_THINGS:
            message = f"this scene has {len(things):,} {what}, and simulation copes with {MAX_THINGS:,}"
            yield Problem(message, parts[what].place, "leave out what the robot does not come near", "too-large")


def _unseen_solids(item: Item) -> Iterator[Problem]:
    """Return percepts of something else that have the name under which a solid object would be seen."""
    parts = item.value if isinstance(item.value, dict) else {}
    percepts = {name: _mapping(percept).get("object") for name, percept in _mapping(parts.get("percepts")).items()}
    seen = {thing.value for thing in percepts.values() if thing is not None}
    for name, thing in _mapping(parts.get("objects")).items():
        solid = _mapping(thing).get("solid")
        if solid is not None and solid.value is True and name not in seen and name in percepts:
            message = f"the solid object {name!r} is not seen: the percept of this name is of another object"
            hint = f"give it a percept of another name, such as {name}_seen: {{object: {name}}}"
            yield Problem(message, parts["percepts"].key_places[name], hint, code="exclusive-keys")


def _written(item: Item, keys: Iterable[str]) -> list[str]:
    """Return those of some keys that have a value."""
    return [key for key in keys if key in item.value and item.value[key].value is not None]


def _misspelt(cls: type, item: Item, keys: Collection[str]) -> bool:
    """Return whether one of some keys, none of which is there, is most likely there but misspelt."""
    known = params_of(cls)
    return bool(unexplained([key for key in item.value if key not in known], known, keys))


def _mapping(item: Item | None) -> dict[str, Item]:
    return item.value if item is not None and isinstance(item.value, dict) else {}


def _no_object(name: Item | None, objects: Collection[str]) -> Iterator[Problem]:
    if name is not None and isinstance(name.value, str) and name.value not in objects:
        hint = nearest(name.value, objects) or "this scene has no objects"
        yield Problem(f"there is no object {name.value!r} in this scene", name.place, hint, code="unknown-object")
