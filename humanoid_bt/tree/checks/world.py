"""Whether a tree goes with the robot and the scene that it is made for."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.plant.scene_config import SceneConfig, load_scene
from humanoid_bt.robot.config import RobotConfig, load_robot_config
from humanoid_bt.tree.checks.facts import Facts
from humanoid_bt.tree.draft import Draft

Config = TypeVar("Config", RobotConfig, SceneConfig)


@dataclass(frozen=True)
class World:
    """The robot and the scene of a tree; None where it names none, or there is none."""

    robot: RobotConfig | None = None
    scene: SceneConfig | None = None

    @classmethod
    def of(
        cls,
        workspace: Workspace,
        header: Item,
        problems: list[Problem],
        robot: str | None = None,
        scene: str | None = None,
    ) -> World:
        """Return the robot and the scene of a tree.

        Args:
            workspace: where they are found.
            header: the tree file, a mapping that may have the keys ``robot`` and ``scene``.
            problems: takes what is wrong with the names, and with the files behind them.
            robot, scene: names that count instead of the file's.
        """

        def named(key: str, instead: str | None) -> Item | None:
            return header.value.get(key) if instead is None else Item(instead, Place(f"{key}={instead}"))

        return cls(
            _found(named("robot", robot), "robot", workspace.find_robot, _robot, problems),
            _found(named("scene", scene), "scene", workspace.find_scene, _scene, problems),
        )


def check_world(root: Draft, facts: Facts, world: World) -> Iterator[Problem]:
    """Return what the tree asks of its robot and its scene that they do not have.

    - a node that commands a resource that the robot does not have;
    - a percept that the scene does not publish.
    """
    if world.robot is not None:
        has, name = world.robot.resources, world.robot.name
        for draft in root.iterate():
            missing = [resource for resource in facts.commands(draft) if resource not in has]
            if missing:
                message = f"{draft.type.type_name!r} commands {', '.join(missing)}: the robot {name!r} has none"
                yield Problem(message, draft.place, f"it has: {', '.join(has)}", "robot-cannot")
    if world.scene is not None:
        yield from _unknown_percepts(root, world.scene)


def _unknown_percepts(root: Draft, scene: SceneConfig) -> Iterator[Problem]:
    """Return each percept that a scene does not publish once, where the tree names it first."""
    uses: dict[str, list[Place]] = {}
    for draft in root.iterate():
        for parameter, percepts in draft.type.percepts(draft.values).items():
            for percept in percepts:
                if percept not in scene.percepts:
                    written = {**draft.value_places, **draft.given_places}
                    uses.setdefault(percept, []).append(written.get(parameter, draft.place))
    for percept, places in uses.items():
        first, others = places[0], len(set(places)) - 1
        hint = nearest(percept, scene.percepts) or "this scene publishes none"
        if others:
            hint += f"; used in {others} more place{'s' if others > 1 else ''}"
        message = f"the scene {scene.name!r} does not publish the percept {percept!r}"
        yield Problem(message, first, hint, "unknown-percept", "warning")


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
