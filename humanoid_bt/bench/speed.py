"""How fast a robot is simulated with each of its bodies, and what a solve of inverse kinematics takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from humanoid_bt.bench.control import PHYSICS, CommandedRobot, beside_physics
from humanoid_bt.bench.figure import Figure, cpu, figure
from humanoid_bt.bench.promises import ARMS, WALKER_SPEED, Promise
from humanoid_bt.control.body.guarded import GuardedBody
from humanoid_bt.control.body.policy.learned_body import LearnedBody
from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.core.clock import SERVO_PERIOD, cycles
from humanoid_bt.core.messages import BaseTarget, HandTarget, Target
from humanoid_bt.robot.config import Walk

_BEGIN, _CYCLES = 1000, 1000  # servo cycles until it does what it is to do, and that are measured
_CPU = "CPU time it took"
_FAR = 100.0  # m ahead
_LIFTED = np.array([0.15, 0.0, 0.15])  # m: by so much the hands are brought ahead and up


def measure_speed(robot: Path, bodies: Sequence[Walk], repetitions: int) -> Iterator[Figure]:
    """Measure a robot in the empty scene, in lockstep, without decision and recording.

    Args:
        robot: its ``robot.yaml``.
        bodies: what walks and balances.
        repetitions: of each pair.

    Raises:
        UserError: the robot has mistakes.
    """
    for body in bodies:
        promise = WALKER_SPEED if body == "policy" else None
        yield _simulated(_begun(robot, body, {}), f"{body} stands", repetitions, promise)
        yield from measure_walk(robot, body, repetitions)
        if (solve := measure_solve(robot, body, repetitions)) is not None:
            yield solve


def measure_walk(robot: Path, body: Walk, repetitions: int) -> tuple[Figure, Figure]:
    """Return how much faster than real time a robot is simulated as it walks, and how much physics alone."""
    walking = _begun(robot, body, {"base": BaseTarget(np.array([_FAR, 0.0]), 0.0)})
    promise = WALKER_SPEED if body == "policy" else None
    whole = _simulated(walking, f"{body} walks", repetitions, promise)
    alone = [(_CYCLES * SERVO_PERIOD, walking.physics(_CYCLES * SERVO_PERIOD)) for _ in range(repetitions)]
    return whole, figure(f"{body} walks: simulated time, mj_step alone", _CPU, "s", alone)


def measure_solve(robot: Path, body: Walk, repetitions: int) -> Figure | None:
    """Return what inverse kinematics takes while both hands are commanded.

    None for a robot without hands, and for a body of the user's own that does not build on one of ours.
    """
    tried = _begun(robot, body, {})
    hands = tried.controller.state().hands
    if not hands:
        return None
    tried.targets = {f"{side}_hand": HandTarget(palm + _LIFTED) for side, palm in hands.items()}
    planner = tried.controller.body
    tried.run(cycles(planner.period))
    if isinstance(planner, GuardedBody):
        planner = planner.guarded
    if not isinstance(planner, (LearnedBody, WholeBody)):
        return None
    pairs = beside_physics(tried, planner.kinematics, "step", planner.period, repetitions)
    what, promise = ("arms", ARMS) if body == "policy" else ("whole body", None)
    name = f"{body} moves both hands: inverse kinematics of the {what}, one solve"
    return figure(name, PHYSICS, "us CPU", pairs, scale=1e6, promise=promise)


def _simulated(robot: CommandedRobot, doing: str, repetitions: int, promise: Promise | None) -> Figure:
    simulated = _CYCLES * SERVO_PERIOD
    pairs = [(simulated, cpu(lambda: robot.run(_CYCLES))) for _ in range(repetitions)]
    return figure(f"{doing}: simulated time", _CPU, "s", pairs, promise=promise)


def _begun(robot: Path, body: Walk, targets: dict[str, Target]) -> CommandedRobot:
    tried = CommandedRobot(targets, robot, body)
    tried.run(_BEGIN)
    return tried
