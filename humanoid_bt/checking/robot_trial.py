"""A robot that is tried in simulation, and what was noticed meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from humanoid_bt.control.body.standing import standing_posture
from humanoid_bt.control.controller import Controller
from humanoid_bt.core.clock import DECISION_PERIOD, CycleClock, cycles
from humanoid_bt.core.errors import Place
from humanoid_bt.core.messages import Array, Mode
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel

LAGS = 0.15
"""How far a joint may be from its setpoint [rad]."""

SATURATED = 0.1
"""Share of the time at its torque limit from which a drive counts as too weak."""


@dataclass
class Seen:
    """What was noticed so far.

    Attributes:
        lag: the joints' largest distance from their setpoints while it stood, shape (nj,) [rad].
        held: torque of each joint as it stood, shape (nj,) [Nm].
        saturated: servo ticks of each joint with all the torque that its drive has, shape (nj,).
        ticks: how many there were.
        touching: pairs of bodies of the robot that touched each other.
        felt: groups of links that something seemed to push -> the largest force [N]: arms that yielded to it, and
            what it was in the way of.
    """

    lag: Array
    held: Array
    saturated: Array
    ticks: int = 0
    touching: set[tuple[str, str]] = field(default_factory=set)
    felt: dict[str, float] = field(default_factory=dict)


class Trial:
    """A robot in an empty scene, and one who commands it as a skill does.

    Attributes:
        robot: its model.
        skill: what commands it, and tells why that does not happen.
        body: what walks and balances, unless it fails.
    """

    def __init__(self, robot: RobotModel) -> None:
        self.robot = robot
        self.plant = MujocoPlant(robot, Scene(SceneConfig(format=1, name="empty"), 0))
        self.plant.place(standing_posture(robot))
        self.controller = Controller(robot, self.plant)
        self.body = self.controller.body
        self._clock = CycleClock()
        self._decision = Robot(robot.config, self._clock, model=robot)
        self.skill = RobotHandle(self._decision, "check", tuple(robot.config.resources))
        joints = len(robot.joint_names)
        self.seen = Seen(np.zeros(joints), np.zeros(joints), np.zeros(joints))

    @property
    def false_contacts(self) -> dict[str, float]:
        """Groups of links that something seemed to push though nothing did -> the largest force [N]."""
        return {} if self.seen.touching else self.seen.felt

    @property
    def fallen(self) -> bool:
        """Whether it has fallen."""
        return self.controller.supervisor.mode is Mode.DAMP

    @property
    def body_failed(self) -> str:
        """When and why its body failed, "" if it has not."""
        return self.controller.body_failed

    def run(self, duration: float, ask: Callable[[RobotHandle], None] | None = None) -> bool:
        """Run for a time [s], or until it falls; return whether it has not.

        Args:
            duration: [s].
            ask: what asks for something in every tick; it stands if None.
        """
        for _ in range(round(duration / DECISION_PERIOD)):
            self.sense()
            if ask:
                ask(self.skill)
            self.controller.submit(self._decision.commit())
            self.controller.run_cycles(cycles(DECISION_PERIOD))
            self._clock.cycle = self.controller.cycle
            if self.fallen:
                return False
            self._look(stands=ask is None)
        return True

    def sense(self) -> None:
        """Let the skill know how the robot is now."""
        self._decision.begin_tick(self.controller.state(), {})

    def _look(self, stands: bool) -> None:
        """Note what is true, and not what sensors say: their noise is more than the fingers of some robots can hold."""
        seen, model, data = self.seen, self.plant.model, self.plant.data
        torques = np.abs(data.actuator_force)
        seen.ticks += 1
        seen.saturated += torques >= self.robot.torque_limit
        if stands:
            angles = data.qpos[BASE_COORDINATES:][: len(torques)]
            off = np.abs(self.controller.servo.command.position - angles)
            seen.lag, seen.held = np.maximum(seen.lag, off), torques
        rule = self.controller.supervisor.touch
        for group, contact in rule.contacts.items():
            if contact.yields or rule.held:
                seen.felt[group] = contact.largest
        robot_bodies = self.robot.model.nbody
        for touch in data.contact[: data.ncon]:
            pair = sorted(int(model.geom_bodyid[geom]) for geom in touch.geom)
            if pair[0] > 0 and pair[1] < robot_bodies and touch.dist < 0:
                seen.touching.add((model.body(pair[0]).name, model.body(pair[1]).name))


def drive_place(robot: RobotModel, joint: str, key: str) -> Place:
    """Return where ``robot.yaml`` says something of the drive of a joint."""
    drive = robot.config.drive(joint)
    index = next(i for i, each in enumerate(robot.config.drives) if each is drive)
    return robot.config.place("drives", index, key)
