"""What the engine costs, each figure beside a baseline in the same run, because absolute times say little."""

from __future__ import annotations

import functools
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import mink
import mujoco
import numpy as np
import py_trees
from py_trees.common import ParallelPolicy, Status

from humanoid_bt.clock import WHOLE_BODY_PERIOD, cycles
from humanoid_bt.control.controller import Controller
from humanoid_bt.control.inverse_kinematics import SOLVER
from humanoid_bt.control.robots import load_robot
from humanoid_bt.messages import JointCommand, State
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.record.sinks import Sinks
from humanoid_bt.robot import Robot
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.options import RunOptions
from humanoid_bt.session.run import Run
from humanoid_bt.testing.rig import ScriptedPerception
from humanoid_bt.tree.executor import Executor
from humanoid_bt.tree.load import load_tree
from humanoid_bt.tree.tree import Tree
from humanoid_bt.workspace import Workspace, builtin_root

_TREE = "fetch"
_CALLS = 400


@dataclass(frozen=True)
class Figure:
    """One measurement.

    Attributes:
        name: what was measured.
        baseline: what it is compared with.
        ours, theirs: median of the repetitions, in ``unit``.
        ratio: median of ours / theirs, pair by pair.
        low, high: smallest and largest ratio.
        must, aim: bounds of the ratio, for people; None where there are none.
        more_is_better: whether the bounds are lower bounds.
    """

    name: str
    baseline: str
    unit: str
    ours: float
    theirs: float
    ratio: float
    low: float
    high: float
    must: float | None = None
    aim: float | None = None
    more_is_better: bool = False

    @property
    def must_text(self) -> str:
        """The bound that has to hold, as text."""
        return self._bound(self.must)

    @property
    def aim_text(self) -> str:
        """The bound that is aimed at, as text."""
        return self._bound(self.aim)

    def _bound(self, value: float | None) -> str:
        return "" if value is None else f"{'>=' if self.more_is_better else '<='} {value:g}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self)


def measure(repetitions: int) -> Iterator[Figure]:
    """Measure everything, one figure after the other.

    Args:
        repetitions: of each pair.
    """
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "bench.rrd"
        yield from _whole_stack(repetitions, recording)
    yield _whole_body(repetitions)
    yield from _tick(repetitions)


# ---- the whole stack against bare physics ---------------------------------------------------------------------------


class _Silent:
    def node_changed(self, _change: object) -> None:
        pass

    def event(self, _time: float, _level: str, _text: str) -> None:
        pass

    def progress(self, _time: float, _running: str) -> None:
        pass

    def show(self, _tree: object) -> None:
        pass


def _whole_stack(repetitions: int, recording: Path) -> Iterator[Figure]:
    workspace = Workspace(builtin_root())
    controls: list[np.ndarray] = []
    run = _new_run(workspace, recording)
    assert isinstance(run.engine, Lockstep)
    plant = run.engine.plant
    start = (plant.data.qpos.copy(), plant.data.qvel.copy())
    step = plant.step

    def note(command: JointCommand) -> None:
        step(command)
        controls.append(plant.data.ctrl.copy())

    plant.step = note  # type: ignore[method-assign]
    run.execute()
    simulated = len(controls) * plant.model.opt.timestep

    def stack() -> float:
        again = _new_run(workspace, recording)
        return _cpu(again.execute)

    def bare() -> float:
        data = mujoco.MjData(plant.model)
        data.qpos[:], data.qvel[:] = start

        def steps() -> None:
            for control in controls:
                data.ctrl[:] = control
                mujoco.mj_step(plant.model, data)

        return _cpu(steps)

    pairs = [(stack(), bare()) for _ in range(repetitions)]
    title = f"whole stack: run {_TREE}, recording on"
    yield _figure(title, "mj_step of the same motion", "ms CPU", pairs, scale=1e3, must=6.0, aim=3.0)
    wall = [(simulated, ours) for ours, _ in pairs]
    yield _figure(
        "lockstep: simulated time, recording on", "CPU time it took", "s", wall, must=4, aim=10, more_is_better=True
    )


def _new_run(workspace: Workspace, recording: Path) -> Run:
    return Run(RunOptions(_TREE, sinks=Sinks(file=recording)), workspace, _Silent())


# ---- whole-body control against the bare solver ---------------------------------------------------------------------


def _whole_body(repetitions: int) -> Figure:
    workspace = Workspace(builtin_root())
    robot, start = load_robot(workspace.find_robot("humanoid"))
    plant = MujocoPlant(robot, Scene(load_scene(workspace.find_scene("empty")), 0))
    plant.place(start)
    controller = Controller(robot, plant)
    period = cycles(WHOLE_BODY_PERIOD)
    kinematics = controller.whole_body.kinematics

    def ours() -> float:
        spent = 0.0
        for _ in range(_CALLS):
            measurement = plant.measure()
            spent += _cpu(lambda: controller.whole_body.update(measurement, {}, False))  # noqa: B023
            for _ in range(period):
                controller.run_cycle()
        return spent / _CALLS

    def theirs() -> float:
        configuration, tasks, limits = kinematics.configuration, kinematics.tasks, kinematics.limits

        def solve() -> None:
            for _ in range(_CALLS):
                mink.solve_ik(configuration, tasks, WHOLE_BODY_PERIOD, SOLVER, limits=limits)

        return _cpu(solve) / _CALLS

    ours()
    pairs = [(ours(), theirs()) for _ in range(repetitions)]
    return _figure("whole-body step: walking, balance, IK, torques", "mink.solve_ik alone", "us CPU", pairs, scale=1e6)


# ---- a tick against plain py_trees ----------------------------------------------------------------------------------


def _tick(repetitions: int) -> Iterator[Figure]:
    workspace = Workspace(builtin_root())
    tree = load_tree(workspace.find_tree(_TREE), workspace)
    state, percepts, robot = _situation(workspace)
    executor = Executor(tree, robot)
    executor.setup()
    executor.tick(state, percepts)
    plain = py_trees.trees.BehaviourTree(plain_copy(tree))
    plain.tick()

    def ours() -> None:
        for _ in range(_CALLS):
            executor.tick(state, percepts)

    def theirs() -> None:
        for _ in range(_CALLS):
            plain.tick()

    nodes = len(tree.nodes)
    whole = _pairs(repetitions, ours, theirs)
    _empty_leaves(tree)
    empty = _pairs(repetitions, ours, theirs)
    title = f"tick of {_TREE}: {nodes} nodes, empty leaves, snapshot and command included"
    yield _figure(title, "tick of py_trees, empty leaves", "us CPU", empty, scale=1e6, must=1.0, aim=0.2)
    yield _figure("the same with its skills and conditions", "the same", "us CPU", whole, scale=1e6)


def _pairs(repetitions: int, ours: Callable[[], None], theirs: Callable[[], None]) -> list[tuple[float, float]]:
    """Measure two functions of many calls in turn; the first pair warms up."""
    pairs = [(_cpu(ours) / _CALLS, _cpu(theirs) / _CALLS) for _ in range(repetitions + 1)]
    return pairs[1:]


def _empty_leaves(tree: Tree) -> None:
    """Let every leaf that was ticked do nothing but return its status again."""
    for node in tree.nodes:
        status = node.behaviour.status
        if node.kind in ("skill", "condition") and status is not Status.INVALID:
            node.behaviour.update = functools.partial(_same, status)  # type: ignore[method-assign]


def _same(status: Status) -> Status:
    return status


def _situation(workspace: Workspace) -> tuple[State, dict[str, Any], Robot]:
    """Return what the tree sees while the robot approaches."""
    robot_model, start = load_robot(workspace.find_robot("humanoid"))
    plant = MujocoPlant(robot_model, Scene(load_scene(workspace.find_scene("empty")), 0))
    plant.place(start)
    state = Controller(robot_model, plant).state()
    perception = ScriptedPerception()
    perception.see("target", (1.5, 0.0, 0.9), 0.95)
    percepts = {percept.name: percept for percept in perception.observe(state)}
    return state, percepts, Robot(robot_model.config, _StoppedClock())


class _StoppedClock:
    def now(self) -> float:
        return 0.0


class _Fixed(py_trees.behaviour.Behaviour):
    """A leaf of py_trees that does nothing but return a status."""

    def __init__(self, name: str, status: Status) -> None:
        super().__init__(name)
        self._fixed = status

    def update(self) -> Status:
        return self._fixed


def plain_copy(tree: Tree) -> py_trees.behaviour.Behaviour:
    """Return a tree of py_trees' own nodes with the shape of a ticked tree, whose leaves return the same again."""
    children: dict[int, list[int]] = {}
    for index, node in enumerate(tree.nodes):
        if not node.branch:
            children.setdefault(node.parent, []).append(index)

    def copy(index: int) -> py_trees.behaviour.Behaviour:
        node = tree.nodes[index]
        below = [copy(child) for child in children.get(index, [])]
        match node.type_name:
            case "sequence":
                return py_trees.composites.Sequence(node.name, node.values.get("memory", False), below)
            case "selector":
                return py_trees.composites.Selector(node.name, node.values.get("memory", False), below)
            case "parallel":
                return py_trees.composites.Parallel(node.name, ParallelPolicy.SuccessOnAll(), below)
        if below:
            return py_trees.decorators.PassThrough(node.name, below[0])
        status = node.behaviour.status
        return _Fixed(node.name, Status.FAILURE if status is Status.INVALID else status)

    return copy(0)


# ---- arithmetic -----------------------------------------------------------------------------------------------------


def _cpu(function: Callable[[], object]) -> float:
    """Return the CPU time [s] that a call takes."""
    begin = time.process_time()
    function()
    return time.process_time() - begin


def _figure(
    name: str,
    baseline: str,
    unit: str,
    pairs: list[tuple[float, float]],
    *,
    scale: float = 1.0,
    must: float | None = None,
    aim: float | None = None,
    more_is_better: bool = False,
) -> Figure:
    ratios = [ours / theirs for ours, theirs in pairs]
    return Figure(
        name,
        baseline,
        unit,
        scale * statistics.median(ours for ours, _ in pairs),
        scale * statistics.median(theirs for _, theirs in pairs),
        statistics.median(ratios),
        min(ratios),
        max(ratios),
        must,
        aim,
        more_is_better,
    )
