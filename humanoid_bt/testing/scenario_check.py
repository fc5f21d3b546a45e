"""What is wrong with a scenario beyond its file: its tree, robot and scene, and the names in it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from humanoid_bt.core.errors import Problem, UserError, nearest
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.plant.scene_config import SceneConfig, load_scene
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.session.loader import DEFAULT_ROBOT, DEFAULT_SCENE
from humanoid_bt.testing.course import Course
from humanoid_bt.testing.events import mistakes
from humanoid_bt.testing.fault import Known
from humanoid_bt.testing.scenario import Scenario, load_scenario
from humanoid_bt.testing.substitution import substituted
from humanoid_bt.tree.source.build import remade
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
    if tree.draft is None or not tree.complete:
        hint = "a tree that has it as a sub-tree"
        yield Problem(f"the tree {tree.name!r} does not run alone", scenario.place("tree"), hint, "unknown-tree")
        return
    if unknown := list(_unknown_nodes(scenario, tree)):
        yield from unknown
        return
    try:
        scene = load_scene(workspace.find_scene(scenario.scene or tree.scene or DEFAULT_SCENE))
        robot = RobotModel(load_robot_config(workspace.find_robot(scenario.robot or tree.robot or DEFAULT_ROBOT)))
        run = remade(tree, substituted(tree, tree.draft, scenario.replace))
    except UserError as error:
        yield from (replace(problem, place=problem.place or scenario.place("tree")) for problem in error.problems)
        return
    for name in scenario.conditions.changed if scenario.dry else ():
        if name in scenario.conditions.of_body:
            message = f"the condition {name!r} needs a body, and a dry run simulates none"
            yield Problem(message, scenario.place("conditions", name), "leave it out, or dry", "exclusive-keys")
    known = _known(scenario, tree, run, scene, robot)
    yield from mistakes(scenario.script, known)
    try:
        scenario.expect.check(run, known.percepts)
    except UserError as error:
        yield from error.problems


def _unknown_nodes(scenario: Scenario, tree: Tree) -> Iterator[Problem]:
    """Return what is to be replaced and is not in the tree."""
    course = Course(tree)
    for node in scenario.replace:
        if not course.nodes(node):
            place = scenario.item.value["replace"].key_places[node]
            message = f"the tree {tree.name!r} has no node {node!r}"
            yield Problem(message, place, nearest(node, course.node_names), "unknown-node")


def _known(scenario: Scenario, loaded: Tree, tree: Tree, scene: SceneConfig, robot: RobotModel) -> Known:
    """Return what names in a scenario can mean."""
    percepts = {*scene.percepts, *(event.see.percept for event in scenario.script if event.see)}
    asked = {*scene.percepts, *loaded.percepts}
    bodies = [robot.model.body(number).name for number in range(1, robot.model.nbody)]
    return Known(tree, robot.config.torso, robot.joint_names, bodies, percepts, asked, scenario.dry)
