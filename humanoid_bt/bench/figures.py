"""What the engine costs, each figure beside a baseline in the same run, because absolute times say little."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import mink
import mujoco
import numpy as np

from humanoid_bt.bench.control import CommandedRobot, measure_control
from humanoid_bt.bench.figure import Figure, cpu, figure
from humanoid_bt.bench.promises import SPEED, STACK
from humanoid_bt.bench.tree import measure_tree
from humanoid_bt.control.body.mink_terms import SOLVER
from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.core.clock import DECISION_PERIOD, WHOLE_BODY_PERIOD, cycles
from humanoid_bt.core.messages import JointCommand
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.session import Session

_TREE = "fetch"
_CALLS = 400


def measure(repetitions: int) -> Iterator[Figure]:
    """Measure everything, one figure after the other.

    Args:
        repetitions: of each pair.
    """
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "bench.rrd"
        yield from _whole_stack(repetitions, recording)
    yield _whole_body(repetitions)
    yield from measure_control(repetitions)
    workspace = Workspace(builtin_root())
    yield from measure_tree(workspace.find_tree(_TREE), workspace, repetitions)


# ---- the whole stack against bare physics ---------------------------------------------------------------------------


def _whole_stack(repetitions: int, recording: Path) -> Iterator[Figure]:
    workspace = Workspace(builtin_root())
    controls: list[np.ndarray] = []
    run = _new_run(workspace, recording)
    assert isinstance(run.engine, Lockstep)
    plant = run.engine.plant
    standing = (plant.data.qpos.copy(), plant.data.qvel.copy())
    step, whole = plant.step, run.engine.model

    def note(command: JointCommand) -> None:
        step(command)
        controls.append(plant.data.ctrl.copy())

    plant.step = note  # type: ignore[method-assign]  # note what is commanded
    run.run()
    simulated = len(controls) * plant.model.opt.timestep

    def stack() -> float:
        ours, start = _new_run(workspace, recording), _new_run(workspace, recording, DECISION_PERIOD)
        return cpu(ours.run) - cpu(start.run)  # the recorder's process imports a lot, once

    def bare() -> float:
        data = mujoco.MjData(whole)
        data.qpos[:], data.qvel[:] = standing

        def steps() -> None:
            for control in controls:
                data.ctrl[:] = control
                mujoco.mj_step(whole, data)

        return cpu(steps)

    pairs = [(stack(), bare()) for _ in range(repetitions)]
    title = f"whole stack: run {_TREE}, recording on, no pictures; begin and end aside"
    yield figure(title, "mj_step of the same motion", "ms CPU", pairs, scale=1e3, promise=STACK)
    wall = [(simulated, ours) for ours, _ in pairs]
    yield figure("lockstep: simulated time, recording on", "CPU time it took", "s", wall, promise=SPEED)


def _new_run(workspace: Workspace, recording: Path, duration: float | None = None) -> Session:
    return Session(_TREE, workspace=workspace, record=recording, camera=False, duration=duration)


# ---- whole-body control against the bare solver ---------------------------------------------------------------------


def _whole_body(repetitions: int) -> Figure:
    controller = CommandedRobot({}).controller
    period = cycles(WHOLE_BODY_PERIOD)
    body = controller.body
    assert isinstance(body, WholeBody)
    kinematics = body.kinematics

    def ours() -> float:
        spent = 0.0
        for _ in range(_CALLS):
            spent += cpu(lambda: body.update(controller.estimator.estimate, {}, False))
            for _ in range(period):
                controller.run_cycle()
        return spent / _CALLS

    def theirs() -> float:
        configuration, tasks, limits = kinematics.configuration, kinematics.tasks, kinematics.limits

        def solve() -> None:
            for _ in range(_CALLS):
                mink.solve_ik(configuration, tasks, WHOLE_BODY_PERIOD, SOLVER, limits=limits)

        return cpu(solve) / _CALLS

    ours()
    pairs = [(ours(), theirs()) for _ in range(repetitions)]
    return figure("whole-body step: walking, balance, IK, torques", "mink.solve_ik alone", "us CPU", pairs, scale=1e6)
