"""What the engine costs, each figure beside a baseline in the same run, because absolute times say little."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import mink

from humanoid_bt.bench.control import CommandedRobot, measure_control
from humanoid_bt.bench.figure import Figure, cpu, figure
from humanoid_bt.bench.motion import Motion
from humanoid_bt.bench.promises import SPEED, STACK
from humanoid_bt.bench.tree import measure_tree
from humanoid_bt.control.body.mink_terms import SOLVER
from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.core.clock import DECISION_PERIOD, WHOLE_BODY_PERIOD, cycles
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.session import Session

_TREE = "fetch"
_STAND = str(Path(__file__).with_name("stand.yaml"))
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
    """Measure what a run costs beyond one that only begins and ends, in which the robot stands for a moment."""
    whole, short = _motion(_new_run(recording)), _motion(_short_run(recording))
    simulated = whole.time - short.time

    def stack() -> float:
        ours, beside = _new_run(recording), _short_run(recording)
        return cpu(ours.run) - cpu(beside.run)

    pairs = [(stack(), cpu(whole.repeat) - cpu(short.repeat)) for _ in range(repetitions)]
    title = f"whole stack: run {_TREE}, recording on, no pictures; begin and end aside"
    yield figure(title, "mj_step of the same motion", "ms CPU", pairs, scale=1e3, promise=STACK)
    wall = [(simulated, ours) for ours, _ in pairs]
    yield figure("lockstep: simulated time, recording on", "CPU time it took", "s", wall, promise=SPEED)


def _motion(run: Session) -> Motion:
    assert isinstance(run.engine, Lockstep)
    return Motion(run.engine.plant, run.run)


def _new_run(recording: Path) -> Session:
    return Session(_TREE, workspace=Workspace(builtin_root()), record=recording, camera=False)


def _short_run(recording: Path) -> Session:
    return Session(
        _STAND, workspace=Workspace(builtin_root()), record=recording, camera=False, duration=DECISION_PERIOD
    )


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
