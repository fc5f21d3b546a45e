"""Whether a tree goes with the robot and the scene that it is made for."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.core.sources import Sources
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import choose, sources_of
from humanoid_bt.plant.scene_config import SceneConfig, load_scene
from humanoid_bt.robot.config import RobotConfig, load_robot_config
from humanoid_bt.tree.checks.facts import Facts
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.expressions.template import Template

Config = TypeVar("Config", RobotConfig, SceneConfig)


@dataclass(frozen=True)
class World:
    """The robot and the scene of a tree, None where it names none, or there is none; what perception publishes."""

    robot: RobotConfig | None = None
    scene: SceneConfig | None = None
    percepts: Collection[str] | None = None

    @classmethod
    def of(
        cls,
        workspace: Workspace,
        header: Item,
        problems: list[Problem],
        robot: str | None = None,
        scene: str | None = None,
        *,
        perception: Sources | None = None,
        others: Collection[str] = (),
    ) -> World:
        """Return the robot and the scene of a tree.

        Args:
            workspace: where they are found.
            header: the tree file, a mapping that may have the keys ``robot`` and ``scene``.
            problems: takes what is wrong with the names, and with the files behind them.
            robot, scene: names that count instead of the file's.
            perception: sources that count instead of the file's.
            others: percepts that come from elsewhere, as through a gateway.
        """

        def named(key: str, instead: str | None) -> Item | None:
            return header.value.get(key) if instead is None else Item(instead, Place(f"{key}={instead}"))

        body = _found(named("robot", robot), "robot", workspace.find_robot, _robot, problems)
        around = _found(named("scene", scene), "scene", workspace.find_scene, _scene, problems)
        sources = sources_of(perception, _sources(header.value.get("perception")), around)
        try:
            chosen = choose(sources, workspace, around or SceneConfig(format=1, name="empty"))
        except UserError as error:
            problems += error.problems
            return cls(body, around)
        known = sources is not None or around is not None
        return cls(body, around, [*others, *(name for one in chosen for name in one.names)] if known else None)


_HANDS = {"left_hand", "right_hand"}


def check_world(root: Draft, facts: Facts, world: World) -> Iterator[Problem]:
    """Return what the tree asks of its robot and its scene that they do not have.

    - a node that commands a resource that the robot does not have;
    - a percept that nothing publishes there.
    """
    if world.robot is not None:
        has, name = world.robot.resources, world.robot.name
        for draft in root.iterate():
            commands = facts.commands(draft)
            missing = [resource for resource in commands if resource not in has]
            one_will_do = getattr(draft.type.cls, "either_hand", False) and _HANDS.issubset(commands)
            if one_will_do and not _HANDS.isdisjoint(has):
                missing = [resource for resource in missing if resource not in _HANDS]
            if missing:
                message = f"{draft.type.type_name!r} commands {', '.join(missing)}: the robot {name!r} has none"
                yield Problem(message, draft.place, f"it has: {', '.join(has)}", "robot-cannot")
    if world.percepts is not None:
        yield from _unknown_percepts(root, world.scene, world.percepts)


def _sources(item: Item | None) -> Sources | None:
    """Return the sources that a file names, None if it names none, or its mistakes are told already."""
    try:
        return None if item is None or item.value is None else Sources.from_item(item)
    except UserError:
        return None


def _unknown_percepts(root: Draft, scene: SceneConfig | None, known: Collection[str]) -> Iterator[Problem]:
    """Return each percept that nothing publishes once, where the tree names it first."""
    uses: dict[str, list[Place]] = {}
    for draft in root.iterate():
        for parameter, percepts in {**_told(draft), **draft.type.percepts(draft.values)}.items():
            for percept in percepts:
                if percept not in known:
                    written = {**draft.value_places, **draft.given_places}
                    uses.setdefault(percept, []).append(written.get(parameter, draft.place))
    for percept, places in uses.items():
        first, others = places[0], len(set(places)) - 1
        hint = nearest(percept, known) or "this scene publishes none"
        if others:
            hint += f"; used in {others} more place{'s' if others > 1 else ''}"
        by = "no percept source publishes"
        if scene is not None and set(known) == set(scene.percepts):
            by = f"the scene {scene.name!r} does not publish"
        message = f"{by} the percept {percept!r}"
        yield Problem(message, first, hint, "unknown-percept", "warning")


def _told(draft: Draft) -> dict[str, list[str]]:
    """Return parameter -> percepts that a node only tells people about, which need no watchdog."""
    texts = {name: value for name, value in draft.values.items() if isinstance(value, Template)}
    return {name: [one for part in text.expressions for one in part.percepts if one] for name, text in texts.items()}


def _found(
    named: Item | None,
    what: str,
    find: Callable[[str], Path],
    load: Callable[[Path, tuple[int, int]], Config],
    problems: list[Problem],
) -> Config | None:
    if named is None or not isinstance(named.value, str):  # a mistake that is told already
        return None
    try:
        path = find(named.value)
        written = path.stat()
    except UserError as error:
        problem = error.problems[0]
        problems.append(Problem(problem.message, named.place, problem.hint, f"unknown-{what}"))
        return None
    except OSError as error:
        message = f"the {what} {named.value!r} cannot be found: {error.strerror}"
        problems.append(Problem(message, named.place, "", f"unknown-{what}"))
        return None
    try:
        return load(path, (written.st_mtime_ns, written.st_size))
    except UserError as error:
        problems += error.problems
        return None


@functools.lru_cache(maxsize=32)
def _robot(path: Path, _version: tuple[int, int]) -> RobotConfig:
    return load_robot_config(path)


@functools.lru_cache(maxsize=32)
def _scene(path: Path, _version: tuple[int, int]) -> SceneConfig:
    return load_scene(path)
