"""Which sources a run has: from what is written to classes with the values of their parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import params_of
from humanoid_bt.core.reading import read_values
from humanoid_bt.core.sources import NamedSource, Sources
from humanoid_bt.core.texts import shortened, told
from humanoid_bt.files.class_files import class_file, method_place, place_in_file
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.source import PerceptSource
from humanoid_bt.perception.source_files import TRACKER, load_sources
from humanoid_bt.perception.tracker import Tracker
from humanoid_bt.plant.scene import Scene, random_stream
from humanoid_bt.plant.scene_config import SceneConfig


@dataclass(frozen=True)
class Chosen:
    """A source of a run.

    Attributes:
        name: its own.
        cls: what it is made of.
        values: every parameter by name, defaults put in.
        names: the percepts that it publishes.
    """

    name: str
    cls: type[PerceptSource]
    values: Mapping[str, Any]
    names: tuple[str, ...]

    def make(self, label: str, scene: Scene) -> PerceptSource:
        """Return the source, not yet set up.

        Args:
            label: what it is called in the run.
            scene: what surrounds the robot; its seed is that of the source's random numbers.

        Raises:
            UserError: its ``__init__`` raises.
        """
        try:
            source = self.cls(**self.values)
        except Exception as error:  # the source's code is the user's
            raise UserError([_raised(self.name, self.cls, "__init__", error)]) from error
        source.names, source.random = self.names, random_stream(scene.seed, "source", label)
        if "scene" in self.cls.needs:
            source.scene = scene
        return source


def labels(chosen: Sequence[Chosen]) -> list[str]:
    """Return what the sources of a run are called: their names, with a number from the second of a name on."""
    count = dict[str, int]()
    found = []
    for one in chosen:
        number = count[one.name] = count.get(one.name, 0) + 1
        found.append(one.name if number == 1 else f"{one.name} {number}")
    return found


def simulated(chosen: Sequence[Chosen]) -> list[str]:
    """Return which sources, by label, look at the simulation: around a real robot nothing of it is there."""
    named = zip(labels(chosen), chosen, strict=True)
    return [label for label, one in named if one.names and not {"scene", "camera"}.isdisjoint(one.cls.needs)]


def written(value: Any, what: str = "perception") -> Sources | None:
    """Return the sources that an argument names, None for None; raises UserError if it names none."""
    if value is None or isinstance(value, Sources):
        return value
    return Sources.from_item(value if isinstance(value, Item) else item_of(value, Place(f"{what}={value}")))


def sources_of(given: Sources | None, tree: Sources | None, scene: SceneConfig | None) -> Sources | None:
    """Return the sources that count: those that a run is given, else those of its tree, else those of its scene."""
    return given or tree or (scene.perception if scene is not None else None)


def choose(sources: Sources | None, workspace: Workspace, scene: SceneConfig) -> list[Chosen]:
    """Return the sources of a run, the simulated tracker if none are named.

    Raises:
        UserError: with everything that is wrong with them: unknown names, wrong parameters, two of them publish one
            percept, or a file in ``perception/`` has mistakes.
    """
    if sources is None:
        return [Chosen(TRACKER, Tracker, {"only": []}, tuple(scene.percepts))]
    known = load_sources(workspace)
    problems: list[Problem] = []
    found: list[tuple[NamedSource, type[PerceptSource], dict[str, Any]]] = []
    for one in sources.every:
        if one.name not in known:
            hint = nearest(one.name, known, "humanoid-bt sources")
            problems.append(Problem(f"no percept source named {one.name!r}", one.place, hint, "unknown-source"))
            continue
        declared = params_of(known[one.name])
        item = Item(one.values.value, one.place, one.values.key_places)
        values, wrong = read_values(declared, item, repr(one.name))
        problems += wrong
        if not wrong:
            defaults = {name: spec.default for name, spec in declared.items()}
            found.append((one, known[one.name], {**defaults, **values}))
    chosen = _published(found, scene, problems)
    if problems:
        raise UserError(problems)
    return chosen


def _published(
    found: list[tuple[NamedSource, type[PerceptSource], dict[str, Any]]], scene: SceneConfig, problems: list[Problem]
) -> list[Chosen]:
    """Return the sources with the percepts that each of them publishes."""
    taken: dict[str, NamedSource] = {}
    names: dict[int, tuple[str, ...]] = {}
    last = [number for number, (_, cls, values) in enumerate(found) if cls is Tracker and not values["only"]]
    for number in sorted(range(len(found)), key=lambda number: number in last):
        one, cls, values = found[number]
        rest = number in last
        own = [name for name in scene.percepts if name not in taken] if rest else _own(one.name, cls, values, problems)
        for name in own:
            if name in taken:
                message = f"two sources publish the percept {name!r}: {taken[name].name!r} and {one.name!r}"
                hint = f"first at {taken[name].place}" if taken[name].place != one.place else ""
                problems.append(Problem(message, one.place, hint, "duplicate-percept"))
            elif cls is Tracker and name not in scene.percepts:
                hint = nearest(name, scene.percepts) or "it has none"
                message = f"the scene {scene.name!r} has no percept {name!r}"
                problems.append(Problem(message, one.values.place_of("only"), hint, "unknown-percept"))
            taken[name] = one
        names[number] = tuple(own)
    return [Chosen(one.name, cls, values, names[number]) for number, (one, cls, values) in enumerate(found)]


def _own(name: str, cls: type[PerceptSource], values: Mapping[str, Any], problems: list[Problem]) -> list[str]:
    """Return the percepts that a source says that it publishes."""
    try:
        given: Any = cls.publishes(values)
        names = list(given) if isinstance(given, Iterable) else [given]
    except Exception as error:  # the source's code is the user's
        problems.append(_raised(name, cls, "publishes", error))
        return []
    if isinstance(given, str) or not all(isinstance(one, str) for one in names):
        message = f"publishes() of the percept source {name!r} gave {shortened(repr(given), 80)}"
        place = method_place(cls, "publishes")
        problems.append(Problem(message, place, "a list of the percepts' names, which may be empty", "broken-source"))
        return []
    return list(dict.fromkeys(names))


def _raised(name: str, cls: type[PerceptSource], method: str, error: Exception) -> Problem:
    """Return what is told of a source whose method raised something."""
    file = class_file(cls)
    place = (place_in_file(error, file) if file else None) or method_place(cls, method)
    message = f"the percept source {name!r} raised {told(error)}"
    return Problem(message, place, f"raised by its {method}", "broken-source")


def refuse_blind(chosen: Sequence[Chosen], sources: Sources) -> None:
    """Refuse sources that a dry run cannot have, which has no picture.

    Raises:
        UserError: one of them needs the head camera.
    """
    if seeing := [one.name for one in chosen if "camera" in one.cls.needs]:
        message = f"the percept source {seeing[0]!r} needs the head camera, and a dry run has no picture"
        raise UserError(message, sources.place, "without dry, or with perception: tracker", "exclusive-keys")
