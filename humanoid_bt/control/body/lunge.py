"""The trunk that lunges after a DCM which no step catches: the hip strategy.

While the trunk gains speed toward where the robot falls, its angular momentum lets the ground push the robot back from
beyond its sole, by s = I alpha / (m g); it takes that back as the trunk comes to rest. What it gave has grown by then,
as everything about the DCM does: the step after the next finds the robot nearer (Pratt, Carff, Drakunov, Goswami,
"Capture point: a step toward humanoid push recovery", Humanoids 2006). It gets upright again once steps catch the
robot, so slowly that soles bear it.
"""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.lean import waist_range
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import RobotModel

_MISSED = 0.03, 0.08  # m that a step misses by, from which the trunk lunges, and with which as far as it may
_FAST, _SLOW = 20.0, 4.0  # rad/s^2 out and back
_BRAKED = 0.8  # of that is counted on to come to rest
_CALM = 0.25  # s in which every step has reached far enough, before a robot that walks gets upright
_PELVIS = 0.2  # of the trunk's lean; more of it takes the hips, and with them the feet, out of reach
_THERE = 1e-4  # rad


class Lunge:
    """How far pelvis and trunk lean after a push.

    Args:
        robot: the robot.
        dt: control period [s].

    Attributes:
        lean: toward where it points, shape (2,), world frame [rad].
        active: whether it leans.
    """

    def __init__(self, robot: RobotModel, dt: float) -> None:
        self._farthest, self._dt = robot.config.gait.lunge, dt
        self._waist = [waist_range(robot, axis) for axis in range(2)]  # by which the trunk rolls, and pitches
        self.reset()

    def reset(self) -> None:
        """Stand upright."""
        self.lean: Array = np.zeros(2)
        self._speed: Array = np.zeros(2)
        self._calm = 0.0  # s in which steps have reached far enough
        self.active = False

    def update(self, missed: Array, steps: bool) -> None:
        """Go on for one control period.

        Args:
            missed: from where the DCM should be when the foot lands that swings to where it will be, shape (2,), world
                frame [m]; none if steps reach far enough, or no foot swings.
            steps: whether the robot steps.
        """
        size, dt = math.hypot(*missed.tolist()), self._dt
        misses = size > _MISSED[0] and self._farthest > 0
        if not (misses or self.active):
            return
        self._calm = 0.0 if misses else self._calm + dt
        goal, most = self.lean, _FAST
        if misses:
            goal = missed * (self._farthest * min(1.0, size / _MISSED[1]) / size)
        elif self._calm > _CALM or not steps:
            goal, most = np.zeros(2), _SLOW
        way = goal - self.lean
        off = max(math.hypot(*way.tolist()), _THERE)
        fastest = math.sqrt(2 * _BRAKED * most * off)  # that still comes to rest there
        gain = way * (fastest / off) - self._speed
        self._speed += gain * min(1.0, most * dt / max(math.hypot(*gain.tolist()), _THERE))
        self.lean = self.lean + self._speed * dt
        self.active = misses or max(np.abs(self.lean).max(), np.abs(self._speed).max() * dt) > _THERE
        if not self.active:
            self.reset()

    def tilts(self, heading: float) -> tuple[float, float, float, float]:
        """Return how far pelvis and trunk are turned about the robot's x and y, which are level [rad].

        Args:
            heading: of the robot.
        """
        if not self.active:
            return 0.0, 0.0, 0.0, 0.0
        x, y = self.lean.tolist()
        cos, sin = math.cos(heading), math.sin(heading)
        turns = sin * x - cos * y, cos * x + sin * y
        roll, pitch = (_PELVIS * turn for turn in turns)
        trunk_roll, trunk_pitch = (
            _PELVIS * turn + min(max((1 - _PELVIS) * turn, least), most)
            for turn, (least, most) in zip(turns, self._waist, strict=True)
        )
        return roll, pitch, trunk_roll, trunk_pitch
