"""What is wrong with a scenario beyond its file: its tree, robot and scene, and the names in it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from humanoid_bt.core.errors import Problem, UserError, nearest
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import choose, refuse_blind, sources_of
from humanoid_bt.plant.scene_config import load_scene
from humanoid_bt.plant.sensor_failures import sensors_of
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.session.loader import DEFAULT_ROBOT, DEFAULT_SCENE
from humanoid_bt.testing.course import Course
from humanoid_bt.testing.events import mistakes
from humanoid_bt.testing.fault import Known
from humanoid_bt.testing.scenario import Scenario, load_scenario, readable_scenario
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
    problems: list[Problem] = []
    scenario: Scenario | None = None
    try:
        scenario = load_scenario(path)
    except UserError as error:
        problems += error.problems
    if (found := scenario or readable_scenario(path)) is not None:
        problems += _findings(found, workspace, whole=scenario is not None)
    if problems or scenario is None:
        raise UserError(list(dict.fromkeys(problems)))
    return scenario


def _findings(scenario: Scenario, workspace: Workspace, whole: bool) -> Iterator[Problem]:
    """Return what is wrong with what a scenario names; ``whole`` unless something was left out that cannot be read."""
    unknown = {key: list(_unknown(scenario, workspace, key)) for key in ("tree", "robot", "scene")}
    yield from itertools.chain(*unknown.values())
    if not unknown["tree"]:
        robot, scene = (None if unknown[key] else getattr(scenario, key) for key in ("robot", "scene"))
        named = replace(scenario, robot=robot, scene=scene)
        sure = {"robot": not unknown["robot"], "scene": whole and not unknown["scene"]}
        yield from _misfits(named, workspace, **sure)


def _unknown(scenario: Scenario, workspace: Workspace, key: str) -> Iterator[Problem]:
    """Return that a tree, a robot or a scene that is named is not there."""
    finds = {"tree": workspace.find_tree, "robot": workspace.find_robot, "scene": workspace.find_scene}
    name = getattr(scenario, key)
    try:
        if name is not None:
            finds[key](name)
    except UserError as error:
        for problem in error.problems:
            yield Problem(problem.message, scenario.place(key), problem.hint, f"unknown-{key}")


def _misfits(scenario: Scenario, workspace: Workspace, robot: bool, scene: bool) -> Iterator[Problem]:
    """Return what is wrong with the tree as it is run, and what the scenario names that is not in it.

    Args:
        scenario: it.
        workspace: where its tree, robot and scene are found.
        robot, scene: whether it is known which joints, and which percepts, there are.
    """
    tree, problems = _tree(scenario, workspace)
    yield from problems
    if tree is None:
        return
    if tree.draft is None or not tree.complete:
        hint = "a tree that has it as a sub-tree"
        yield Problem(f"the tree {tree.name!r} does not run alone", scenario.place("tree"), hint, "unknown-tree")
        return
    unknown = dict(_unknown_nodes(scenario, tree))
    yield from unknown.values()
    run = remade(tree, tree.draft)
    try:
        stand_ins = {node: of for node, of in scenario.replace.items() if node not in unknown}
        run = remade(tree, substituted(tree, tree.draft, stand_ins))
    except UserError as error:
        yield from (replace(problem, place=problem.place or scenario.place("tree")) for problem in error.problems)
    try:
        there = load_scene(workspace.find_scene(scenario.scene or tree.scene or DEFAULT_SCENE))
        model = RobotModel(load_robot_config(workspace.find_robot(scenario.robot or tree.robot or DEFAULT_ROBOT)))
        sources = sources_of(scenario.perception, tree.perception, there)
        chosen = choose(sources, workspace, there)
        if scenario.dry and sources is not None:
            refuse_blind(chosen, sources)
    except UserError as error:
        yield from (replace(problem, place=problem.place or scenario.place("tree")) for problem in error.problems)
        return
    for name, problem in scenario.conditions.refused(model, chosen, scenario.dry):
        yield replace(problem, place=scenario.place("conditions", name))
    known = _known(scenario, tree, run, [name for one in chosen for name in one.names], model)
    if not scene:
        known = known._replace(percepts=None, asked=())
    unsure = () if robot else ("unknown-joint", "unknown-body")
    yield from (problem for problem in mistakes(scenario.script, known) if problem.code not in unsure)
    try:
        scenario.expect.check(run, known.percepts)
    except UserError as error:
        yield from error.problems


def _tree(scenario: Scenario, workspace: Workspace) -> tuple[Tree | None, list[Problem]]:
    """Return the tree as it is run, without the values of its parameters if they have mistakes, and the mistakes."""
    path, problems = workspace.find_tree(scenario.tree), list[Problem]()
    for parameters in (scenario.parameters.items, {}):
        try:
            tree = load_tree(
                path,
                workspace,
                parameters,
                robot=scenario.robot,
                scene=scenario.scene,
                perception=scenario.perception,
            )
            return tree, problems
        except UserError as error:
            problems = problems or [problem for problem in error.problems if problem.severity == "error"]
    return None, problems


def _unknown_nodes(scenario: Scenario, tree: Tree) -> Iterator[tuple[str, Problem]]:
    """Return what is to be replaced and is not in the tree, each with its mistake."""
    course = Course(tree)
    for node in scenario.replace:
        if not course.nodes(node):
            place = scenario.item.value["replace"].key_places[node]
            message = f"the tree {tree.name!r} has no node {node!r}"
            yield node, Problem(message, place, nearest(node, course.node_names), "unknown-node")


def _known(scenario: Scenario, loaded: Tree, tree: Tree, published: Sequence[str], robot: RobotModel) -> Known:
    """Return what names in a scenario can mean."""
    percepts = {*published, *(event.see.percept for event in scenario.script if event.see)}
    asked = {*published, *loaded.percepts}
    sensors = sensors_of(robot.config.sensors, robot.joint_names)
    bodies = [robot.model.body(number).name for number in range(1, robot.model.nbody)]
    return Known(tree, robot.config.torso, robot.joint_names, sensors, bodies, percepts, asked, scenario.dry)
