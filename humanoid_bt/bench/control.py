"""What parts of control cost, of a robot that walks or presses its hands together."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from humanoid_bt.bench.figure import Figure, Pairs, cpu, figure
from humanoid_bt.bench.motion import Motion
from humanoid_bt.bench.promises import ESTIMATE, LOG, LOG_USUAL, OWN_LINKS
from humanoid_bt.control.body.body import Body
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.control.controller import Controller
from humanoid_bt.control.cycle_log import CycleLog, Layout
from humanoid_bt.control.servo import Servo
from humanoid_bt.control.supervisor import Supervisor
from humanoid_bt.core.clock import DECISION_PERIOD, ESTIMATE_PERIOD, SERVO_PERIOD, cycles
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import BaseTarget, Command, Estimate, HandTarget, Target
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.link.table import LocalTable
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.robot.config import Walk

_BEGIN, _CYCLES = 1000, 2000  # servo cycles until it walks, and that are measured
_FAR = {"base": BaseTarget(np.array([100.0, 0.0]), 0.0)}
_HANDS = {f"{side}_hand": HandTarget(np.array([0.3, 0.0, 0.95])) for side in ("left", "right")}
PHYSICS = "mj_step for as long"


class CommandedRobot:
    """A robot in the empty scene, with the same targets in every tick.

    Args:
        targets: resource -> target.
        file: its ``robot.yaml``; the built-in one's if None.
        walk: what walks and balances; what ``robot.yaml`` says if None.

    Attributes:
        targets: as given; they count from the next tick on.
        controller, plant: its own.
    """

    def __init__(self, targets: dict[str, Target], file: Path | None = None, walk: Walk | None = None) -> None:
        workspace = Workspace(builtin_root())
        robot, start = load_robot(file or workspace.find_robot("humanoid"), walk)
        self.plant = MujocoPlant(robot, Scene(load_scene(workspace.find_scene("empty")), 0))
        self.plant.place(start)
        self.controller = Controller(robot, self.plant)
        self._config = robot.config
        self.targets = targets

    def run(self, count: int) -> None:
        """Run so many servo cycles.

        Raises:
            UserError: the robot's body fails, and what is measured from then on is another one.
        """
        controller, tick = self.controller, cycles(DECISION_PERIOD)
        end = controller.cycle + count
        while controller.cycle < end:
            if controller.cycle % tick == 0:
                controller.submit(Command(controller.cycle, controller.cycle * SERVO_PERIOD, self.targets))
            controller.run_cycles(min(end - controller.cycle, tick - controller.cycle % tick))
        if failed := controller.body_failed:
            raise UserError(
                f"{self._config.name} cannot be measured: {failed}", self._config.place("body"), code="failed-body"
            )

    def physics(self, time: float) -> float:
        """Return the CPU time of bare physics for some time [s] of what the robot goes on to do [s]."""
        motion = Motion(self.plant, lambda: self.run(_CYCLES))
        return cpu(motion.repeat) / motion.time * time


def measure_control(repetitions: int) -> Iterator[Figure]:
    """Measure the estimator, own links that are kept apart, and the log of servo cycles.

    Args:
        repetitions: of each pair.
    """
    walking, pressing = CommandedRobot(dict(_FAR)), CommandedRobot(dict(_HANDS))
    robots = (walking, pressing)
    for robot in robots:
        robot.run(_BEGIN)
    title = "estimating the robot, walking"
    pairs = beside_physics(walking, walking.controller.estimator, "update", ESTIMATE_PERIOD, repetitions)
    yield figure(title, PHYSICS, "us CPU", pairs, scale=1e6, promise=ESTIMATE)
    body = pressing.controller.body
    assert isinstance(body, WholeBody)
    own_links = body.kinematics.limits[0]
    title = "keeping own links apart in one solve, hands pressed together"
    pairs = beside_physics(pressing, own_links, "compute_qp_inequalities", body.period, repetitions)
    yield figure(title, PHYSICS, "us CPU", pairs, scale=1e6, promise=OWN_LINKS)
    for robot, doing in zip(robots, ("walking", "both hands commanded"), strict=True):
        yield from _log(doing, robot, repetitions)


def beside_physics(robot: CommandedRobot, owner: object, method: str, period: float, repetitions: int) -> Pairs:
    """Return what a call of an object's method takes while the robot goes on, and what bare physics does [s].

    Args:
        robot: it.
        owner, method: what is called.
        period: time between two calls, for which physics is reckoned [s].
        repetitions: of the pair.
    """
    spent = _note_time(owner, method)

    def ours() -> float:
        spent.clear()
        robot.run(_CYCLES)
        return statistics.fmean(spent)

    pairs = [(ours(), robot.physics(period)) for _ in range(repetitions)]
    delattr(owner, method)
    return pairs


def _note_time(owner: object, method: str) -> list[float]:
    """Have an object note how much CPU time each call of a method takes [s]."""
    spent: list[float] = []
    call: Callable[..., object] = getattr(owner, method)

    def noted(*arguments: object, **named: object) -> object:
        began = time.thread_time()
        result = call(*arguments, **named)
        spent.append(time.thread_time() - began)
        return result

    setattr(owner, method, noted)
    return spent


# ---- keeping servo cycles -------------------------------------------------------------------------------------------


class _TimedLog(CycleLog):
    """Notes how long it takes in each cycle [s], without what it takes to read the clock."""

    def __init__(self, plans: LocalTable, servo_cycles: LocalTable, layout: Layout) -> None:
        super().__init__(plans, servo_cycles, layout)
        self.spent: list[float] = []

    def begin(self, cycle: int, supervisor: Supervisor, servo: Servo, body: Body) -> None:
        began = time.perf_counter()
        CycleLog.begin(self, cycle, supervisor, servo, body)
        ended = time.perf_counter()
        self.spent.append(ended - began - (time.perf_counter() - ended))

    def end(self, estimate: Estimate) -> None:
        began = time.perf_counter()
        CycleLog.end(self, estimate)
        ended = time.perf_counter()
        self.spent[-1] += ended - began - (time.perf_counter() - ended)


def _log(doing: str, robot: CommandedRobot, repetitions: int) -> Iterator[Figure]:
    layout = Layout.of(robot.plant.robot.joint_names)
    log = robot.controller.log = _TimedLog(*layout.local(), layout)

    def once() -> tuple[float, float, float]:
        log.spent.clear()
        robot.run(_CYCLES)
        half, most = np.percentile(log.spent, (50, 99))
        return float(half), float(most), robot.physics(SERVO_PERIOD)

    once()
    gc.disable()  # as in control's process
    measured = [once() for _ in range(repetitions)]
    gc.enable()
    name = f"keeping a servo cycle for the recording, {doing}"
    usual, longest = [(half, physics) for half, _, physics in measured], [(most, step) for _, most, step in measured]
    yield figure(f"{name}, p50", PHYSICS, "us", usual, scale=1e6, promise=LOG_USUAL)
    yield figure(f"{name}, p99", PHYSICS, "us", longest, scale=1e6, promise=LOG)
