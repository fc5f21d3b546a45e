"""What a tick and the loading of a tree cost, beside plain py_trees and plain YAML."""

from __future__ import annotations

import gc
import tempfile
from collections.abc import Iterator
from pathlib import Path

import py_trees
import yaml

from humanoid_bt.bench.figure import Figure, Pairs, cpu, figure, in_turn
from humanoid_bt.bench.plain import empty_leaves, plain_copy
from humanoid_bt.bench.promises import LOAD, TICK
from humanoid_bt.bench.samples import sample_tree
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.control.controller import Controller
from humanoid_bt.core.messages import Percept, State
from humanoid_bt.core.odometry import truth_of
from humanoid_bt.decision.robot import Robot
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.session.loader import DEFAULT_ROBOT
from humanoid_bt.testing.scripted_perception import ScriptedPerception
from humanoid_bt.tree.source.load import load_tree
from humanoid_bt.tree.ticking.executor import Executor
from humanoid_bt.tree.tree import Tree

_TICKS, _LOADS = 1000, 4  # in one measurement
_SEEN_AT = (1.5, 0.0, 0.9)  # m, where every percept is: ahead, to be walked to
_CONFIDENCE = 0.95
_TICKED, _LOADED = 40, 500  # nodes of the sample trees


def measure_tree(path: Path, workspace: Workspace, repetitions: int) -> Iterator[Figure]:
    """Measure ticks of a tree and of a sample of 40 nodes, and the loading of a sample of 500.

    Args:
        path: the tree's file.
        workspace: where its skills and its robot are found.
        repetitions: of each pair.

    Raises:
        UserError: the tree, a skill or the robot has mistakes.
        NodeError: a skill raised an exception.
    """
    ours, theirs = _Situation(path, workspace), _Situation(path, workspace)
    title = f"tick of {ours.tree.name}: {len(ours.tree.nodes)} nodes, snapshot and command included"
    same = figure(
        title,
        "py_trees, the same leaves, snapshot, command",
        "us CPU",
        _same_leaves(ours, theirs, repetitions),
        scale=1e6,
    )
    empty = _empty_leaves(ours, repetitions)
    yield figure(f"{title}, empty leaves", "py_trees, empty leaves", "us CPU", empty, scale=1e6, promise=TICK)
    yield same
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sample.yaml"
        file.write_text(sample_tree(_TICKED), encoding="utf-8")
        sample = _Situation(file, workspace)
        title = f"tick of a {len(sample.tree.nodes)}-node tree, snapshot and command included, empty leaves"
        pairs = _empty_leaves(sample, repetitions)
        yield figure(title, "py_trees, empty leaves", "us CPU", pairs, scale=1e6, promise=TICK)
        file.write_text(sample_tree(_LOADED), encoding="utf-8")
        yield _load(file, workspace, repetitions)


class _Situation:
    """A tree that was ticked once, for a robot that stands and sees everything ahead of it."""

    def __init__(self, path: Path, workspace: Workspace) -> None:
        self.tree = load_tree(path, workspace)
        model, start = load_robot(workspace.find_robot(self.tree.robot or DEFAULT_ROBOT))
        plant = MujocoPlant(model, Scene(load_scene(workspace.find_scene("empty")), 0))
        plant.place(start)
        self.robot = Robot(model.config, _StoppedClock())
        self.state: State = Controller(model, plant).state()
        self.percepts = _percepts(self.tree, self.state)
        self.executor = Executor(self.tree, self.robot)
        self.executor.setup()
        self.tick()

    def tick(self) -> None:
        self.executor.tick(self.state, self.percepts)


def _percepts(tree: Tree, state: State) -> dict[str, Percept]:
    perception = ScriptedPerception()
    for node in tree.nodes:
        for names in node.type.percepts(node.values).values():
            for name in names:
                perception.see(name, _SEEN_AT, _CONFIDENCE)
    return {percept.name: percept for percept in perception.observe(truth_of(state))}


class _StoppedClock:
    def now(self) -> float:
        return 0.0


def _empty_leaves(ours: _Situation, repetitions: int) -> Pairs:
    empty_leaves(ours.tree)
    plain = py_trees.trees.BehaviourTree(plain_copy(ours.tree))
    return in_turn(repetitions, lambda: cpu(ours.tick, _TICKS), lambda: cpu(plain.tick, _TICKS))


def _same_leaves(ours: _Situation, theirs: _Situation, repetitions: int) -> Pairs:
    """Measure with the tree's own leaves, which ``theirs`` gives away."""
    plain = py_trees.trees.BehaviourTree(plain_copy(theirs.tree, same_leaves=True))

    def tick() -> None:
        theirs.robot.begin_tick(theirs.state, theirs.percepts)
        plain.tick()
        theirs.robot.commit()

    return in_turn(repetitions, lambda: cpu(ours.tick, _TICKS), lambda: cpu(tick, _TICKS))


def _load(file: Path, workspace: Workspace, repetitions: int) -> Figure:
    text = file.read_text(encoding="utf-8")
    nodes = len(load_tree(file, workspace).nodes)
    gc.disable()  # a collection takes half as long as a load, and would count for either of the two
    pairs = in_turn(
        repetitions,
        lambda: cpu(lambda: load_tree(file, workspace), _LOADS),
        lambda: cpu(lambda: yaml.safe_load(text), _LOADS),
    )
    gc.enable()
    title = f"load of a {nodes}-node tree with all checks"
    return figure(title, "yaml.safe_load of its text", "s CPU", pairs, promise=LOAD)
