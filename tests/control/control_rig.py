"""A robot in an empty scene with its controller, for tests: commands every 20 cycles, as decision gives them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest

from humanoid_bt.control.controller import Controller
from humanoid_bt.core.clock import DECISION_PERIOD, SERVO_PERIOD, cycles
from humanoid_bt.core.messages import Array, Command, Reading, State, Target
from humanoid_bt.plant.interface import SILENT_AFTER
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.robot.model import RobotModel

TICK = cycles(DECISION_PERIOD)
SETTLE_TIME = 4.0  # s in which a walking robot has come to a stand


def empty_scene() -> Scene:
    return Scene(SceneConfig(format=1, name="empty"), 0)


class ControlRig:
    def __init__(self, robot: RobotModel, standing: Array) -> None:
        self.robot, self.standing = robot, standing
        self.plant = MujocoPlant(robot, empty_scene())
        self.plant.place(standing)
        self.controller = Controller(robot, self.plant)
        self.sequence = 0

    def reset(self) -> None:
        self.plant.place(self.standing)
        self.controller.reset()
        self.sequence = 0

    @property
    def state(self) -> State:
        return self.controller.state()

    def run(
        self,
        seconds: float,
        targets: Mapping[str, Target] | None = None,
        until: Callable[[State], bool] | None = None,
        cycle: Callable[[], object] | None = None,
    ) -> bool:
        """Run with these targets commanded (None: decision is silent); return whether ``until`` came true.

        ``cycle`` is called after each servo cycle.
        """
        for _ in range(round(seconds / DECISION_PERIOD)):
            if targets is not None:
                self.command(targets)
            if cycle is None:
                self.controller.run_cycles(TICK)
            else:
                for _ in range(TICK):
                    self.controller.run_cycle()
                    cycle()
            if until is not None and until(self.state):
                return True
        return False

    def command(self, targets: Mapping[str, Target], stamp: float | None = None) -> bool:
        now = self.controller.cycle * SERVO_PERIOD if stamp is None else stamp
        sources = {resource: f"root/{resource}" for resource in targets}
        self.sequence += 1
        return self.controller.submit(Command(self.sequence, now, dict(targets), sources))

    def stands(self) -> bool:
        """Wait until the robot stands at rest, without commanding anything new."""
        return self.run(SETTLE_TIME, until=lambda state: state.base_settled)

    def silence(self, monkeypatch: pytest.MonkeyPatch, duration: float) -> None:
        """Let the plant say nothing new from now on for a time [s], and be known to fail from the 20th cycle on."""
        measure = self.plant.measure
        last = measure()

        def measured(into: Reading | None = None) -> Reading:
            reading = measure(into)
            silent_for = reading.time - last.time
            if silent_for < duration:
                reading.age, reading.passed = silent_for, 0
                reading.values[:] = last.values
            else:
                reading.age, reading.passed = 0.0, 1
            monkeypatch.setattr(self.plant, "fault", "it is silent" if reading.age > SILENT_AFTER else "")
            return reading

        monkeypatch.setattr(self.plant, "measure", measured)
