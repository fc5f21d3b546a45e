"""What is wrong with a scenario beyond its file: its tree, robot and scene, and the names in it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from humanoid_bt.core.errors import Problem, UserError, nearest
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.plant.scene_config import load_scene
from humanoid_bt.session.loader import DEFAULT_SCENE
from humanoid_bt.testing.course import Course
from humanoid_bt.testing.scenario import Scenario, load_scenario
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.tree import Tree


def checked_scenario(path: Path, workspace: Workspace) -> Scenario:
    """Read a scenario file and look up all that it names.

    Args:
        path: the file.
        workspace: where its tree, robot and scene are found.

    Raises:
        UserError: with every problem found, each with its place, those of its tree among them.
    """
    scenario = load_scenario(path)
    problems = list(_unknown(scenario, workspace))
    if not problems:
        problems = list(_misfits(scenario, workspace))
    if problems:
        raise UserError(problems)
    return scenario


def _unknown(scenario: Scenario, workspace: Workspace) -> Iterator[Problem]:
    """Return what names a tree, a robot or a scene that is not there."""
    finds = {"tree": workspace.find_tree, "robot": workspace.find_robot, "scene": workspace.find_scene}
    for key, find in finds.items():
        name = getattr(scenario, key)
        try:
            if name is not None:
                find(name)
        except UserError as error:
            for problem in error.problems:
                yield Problem(problem.message, scenario.place(key), problem.hint, f"unknown-{key}")


def _misfits(scenario: Scenario, workspace: Workspace) -> Iterator[Problem]:
    """Return what is wrong with the tree as it is run, and what the scenario names that is not in it."""
    try:
        path = workspace.find_tree(scenario.tree)
        tree = load_tree(path, workspace, scenario.parameters.items, robot=scenario.robot, scene=scenario.scene)
    except UserError as error:
        yield from (problem for problem in error.problems if problem.severity == "error")
        return
    if not tree.complete:
        hint = "a tree that has it as a sub-tree"
        yield Problem(f"the tree {tree.name!r} does not run alone", scenario.place("tree"), hint, "unknown-tree")
        return
    course = Course(tree)
    for node in scenario.replace:
        if not course.nodes(node):
            message = f"the tree {tree.name!r} has no node {node!r}"
            place = scenario.item.value["replace"].key_places[node]
            yield Problem(message, place, nearest(node, course.node_names), "unknown-node")
    try:
        scenario.expect.check(tree, _percepts(scenario, tree, workspace))
    except UserError as error:
        yield from error.problems


def _percepts(scenario: Scenario, tree: Tree, workspace: Workspace) -> set[str]:
    """Return the percepts that there may be: those of the scene, and those that the script dictates.

    Raises:
        UserError: the scene has mistakes.
    """
    scene = load_scene(workspace.find_scene(scenario.scene or tree.scene or DEFAULT_SCENE))
    return {*scene.percepts, *(event.see.percept for event in scenario.script if event.see)}
