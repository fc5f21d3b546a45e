"""The references of the trunk's lean and the crouch with which the body helps the eyes to see what is low and near."""

from __future__ import annotations

import math

from humanoid_bt.control.body.references import approach
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import RobotModel

_SPEED = 0.4  # rad/s
_SINK_SPEED = 0.05  # m/s
_SINK = 0.6  # m for a radian that leaning lacks
_UPRIGHT = 0.3  # rad that the pelvis' lean stays away from what counts as a fall
_ALONG = 0.9  # of a joint's axis along the robot's, for the joint to turn the trunk about that


class LeanReference:
    """How far the trunk leans ahead to keep in view what the neck, if there is one, does not turn down to.

    The waist leans first; what it cannot do the pelvis does, on the hips; then the body sinks.

    Args:
        robot: the robot.
        dt: control period [s].

    Attributes:
        torso: lean of the torso [rad].
        crouch: how far the body sinks [m].
    """

    def __init__(self, robot: RobotModel, dt: float) -> None:
        config = robot.config
        neck = _turns(robot, robot.joint(config.neck.pitch), 1)[1] if config.neck else 0.0
        self._unaided = config.gaze.down + neck + config.whole_body.gaze_below
        self._waist, self._dt = waist_range(robot, 1)[1], dt
        self._farthest = min(config.whole_body.gaze_lean, self._waist + max(0.0, config.fall.tilt - _UPRIGHT))
        self._deepest = config.whole_body.gaze_crouch
        self.reset()

    def reset(self) -> None:
        """Stand upright."""
        self.torso = self.crouch = 0.0

    def update(self, point: Array | None, hold: bool, eyes: Array, base: Array, heading: float) -> None:
        """Lean toward a point, world frame, shape (3,); stand up if None.

        Args:
            point: what to look at.
            hold: stay.
            eyes, base: positions of the gaze site and of the pelvis, world frame, shape (3,) [m].
            heading: of the stance [rad].
        """
        if hold or (point is None and not self.torso and not self.crouch):
            return
        goal = 0.0
        if point is not None:
            (x, y, z), (eyes_x, eyes_y, eyes_z), (base_x, base_y, _) = point.tolist(), eyes.tolist(), base.tolist()
            below = max(0.0, math.atan2(eyes_z - z, math.hypot(x - eyes_x, y - eyes_y)) - self._unaided)
            aside = math.atan2(y - base_y, x - base_x) - heading
            goal = below * math.cos(aside)  # what is aside does not come into view by leaning
        lacking = min(max(_SINK * (goal - self._farthest), 0.0), self._deepest)
        self.torso = approach(self.torso, min(max(goal, 0.0), self._farthest), _SPEED * self._dt)
        self.crouch = approach(self.crouch, lacking, _SINK_SPEED * self._dt)

    @property
    def base(self) -> float:
        """Lean of the pelvis [rad]."""
        return max(0.0, self.torso - self._waist)


def _turns(robot: RobotModel, joint: int, axis: int) -> tuple[float, float]:
    """Return from where to where a joint turns about an axis of the robot (0: x, 1: y) [rad]."""
    low, high = robot.lower.item(joint), robot.upper.item(joint)
    return (-high, -low) if robot.axes[joint, axis] < 0 else (low, high)


def waist_range(robot: RobotModel, axis: int) -> tuple[float, float]:
    """Return how far the joints between the base and the torso turn it about an axis, both ways [rad].

    Args:
        robot: the robot.
        axis: 0 to roll it, 1 to pitch it.
    """
    model, config = robot.model, robot.config
    base, body = model.body(config.base).id, model.body(config.torso).id
    least = most = 0.0
    while body not in (base, 0):
        first = int(model.body_jntadr[body])
        for joint in range(first, first + int(model.body_jntnum[body])):
            if abs(robot.axes[joint - 1, axis]) > _ALONG:
                low, high = _turns(robot, joint - 1, axis)
                least, most = least + min(low, 0.0), most + max(high, 0.0)
        body = int(model.body_parentid[body])
    return least, most
