"""A run in lockstep whose robot is behind a simulated cable."""

from __future__ import annotations

import numpy as np

from humanoid_bt.cable.impairment import Impairment
from humanoid_bt.cable.lockstep import LockstepPlant
from humanoid_bt.cable.payloads import Hello
from humanoid_bt.cable.safe_state import WATCHDOG, SafeState
from humanoid_bt.control.controller import Controller
from humanoid_bt.core.messages import Array, JointCommand
from humanoid_bt.perception.interface import Perception
from humanoid_bt.plant.scene import Scene
from humanoid_bt.realtime.served_simulation import ServedSimulation
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.session.lockstep import Lockstep

PERFECT = Impairment()
LOSSY = Impairment(latency=0.001, jitter=0.001, loss=0.01)


class CabledLockstep(Lockstep):
    """Lockstep, with a cable between control and the simulation.

    Attributes:
        cabled: the cable with both its ends.
    """

    def __init__(
        self,
        robot: RobotModel,
        start: Array,
        scene: Scene,
        perception: Perception,
        *,
        impairment: Impairment = LOSSY,
        safe: SafeState = "hold",
        seed: int = 0,
    ) -> None:
        super().__init__(robot, start, scene, perception)
        served = ServedSimulation(robot, start, scene, WATCHDOG, safe)
        hello = Hello(robot.config.name, tuple(robot.joint_names), scene.config.name, scene.seed)
        self.cabled = LockstepPlant(served, hello, impairment, seed)
        self.plant = served.simulation.plant
        self.controller = Controller(robot, self.cabled, scene.start_pose)

    def reset(self, perception: Perception, scene: Scene | None = None) -> None:
        self.cabled.restart()
        super().reset(perception, scene)


def still(cabled: LockstepPlant) -> JointCommand:
    """Return a command that lets the robot stay as it is."""
    reading = cabled.measure()
    zeros = np.zeros_like(reading.joint_position)
    return JointCommand(reading.joint_position, zeros, zeros + 200.0, zeros + 5.0, zeros)
