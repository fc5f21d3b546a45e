"""References of hands, arms, gaze, posture and of the height of the centre of mass.

They follow targets at limited speed, and come to rest when released.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from humanoid_bt.control.body.planar import ahead, rotate, seen_from, wrap
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import ArmTarget, Array
from humanoid_bt.robot.config import WholeBodyConfig

_CORRECT_WITHIN = 0.05  # m from the target at which the measured error is integrated
_CORRECT_MAX = 0.05  # m
_REGAIN = 0.05  # m within reach again, before a hand that was let go follows (hysteresis)
_PITCH_RANGE = (-0.5, 0.8)  # rad, up and down
_NECK_SHARE = 0.9  # of the neck's range that is used before the torso helps
_SUNK = 0.01  # m that a robot that steps may be lower than the reference of its height, which then sinks with it
_SINK_SPEED, _RISE_SPEED = 1.0, 0.6  # m/s of this reference
_STRETCH_TIME = 0.2  # s in which knees straighten in long steps, and bend again
_RELAX_SPEED = 1.0  # rad/s at which released joints go back to the home posture


class HandReference:
    """The reference of one palm: goes to the target at limited speed, then corrects the measured error.

    A held palm is held relative to the stance. Were it held in the world, a robot that finishes its step would walk on
    against its own arm. For the same reason a hand is let go while the robot walks and its target is out of reach; it
    follows again once the target is within reach.

    The reference is never more than ``hand_lead`` ahead of the palm of the inverse kinematics: a target out of reach
    pulls at the body no harder than that, and a hand whose target comes back turns at once.

    Args:
        weights: the robot's numbers.
        dt: control period [s].
    """

    def __init__(self, weights: WholeBodyConfig, dt: float) -> None:
        self._weights, self._dt = weights, dt
        self._position: Array | None = None  # on the way to the target
        self._correction: Array = np.zeros(3)
        self._sent: Array = np.zeros(3)  # what was returned last, unless the palm fell behind
        self._stance: Array = np.zeros(3)  # what these belong to
        self._let_go = False

    def update(
        self,
        target: Array | None,
        hold: bool,
        measured: Array,
        reference: Array,
        *,
        stance: Array,
        walks: bool = False,
        speed: float | None = None,
        corrects: bool = True,
    ) -> Array | None:
        """Return where the inverse kinematics shall bring the palm, or None when it is free.

        Args:
            target: world frame, shape (3,) [m]; None to release the hand.
            hold: stay where the reference is, as seen from the stance, whatever the target.
            measured, reference: palm positions, of the robot and of the inverse kinematics, shape (3,) [m].
            stance: pose of the middle between the feet, world frame, shape (3,).
            walks: whether the stance moves.
            speed: at most this fast [m/s]; the robot's own limit if None.
            corrects: whether the measured error from the reference is integrated; not where the palm meets something on
                its way.
        """
        lead = self._weights.hand_lead
        before, self._stance = self._stance, stance
        if hold:
            if self._position is None:
                return None
            self._position = _carried(self._position, before, stance)
            self._sent = _carried(self._sent, before, stance)
            self._correction[:2] = rotate(self._correction[:2], stance[2] - before[2])
            return _toward(reference, self._sent, lead)
        if target is None:
            self._let_go = False
        if target is None or self._lets_go(target, stance, walks):
            self.let_go()
            return None
        if self._position is None:
            self._position = self._sent = reference.copy()
        fastest = self._weights.hand_speed
        step = (fastest if speed is None else min(speed, fastest)) * self._dt
        error = target - self._position
        self._position = _toward(self._position, target, step)
        self._position = _toward(reference - self._correction, self._position, lead)
        if corrects and error.dot(error) < _CORRECT_WITHIN**2:
            correction = self._correction + self._weights.hand_integral * self._dt * (self._position - measured)
            self._correction = clamp(correction, -_CORRECT_MAX, _CORRECT_MAX)
        self._sent = _toward(self._sent, self._position + self._correction, step)
        return _toward(reference, self._sent, lead)

    @property
    def free(self) -> bool:
        """Whether nothing holds the hand, and nothing did that it was let go of meanwhile."""
        return self._position is None and not self._let_go

    def let_go(self) -> None:
        """Let the hand go, whatever held it."""
        self._position = None
        self._correction = np.zeros(3)

    def _lets_go(self, target: Array, stance: Array, walks: bool) -> bool:
        weights, margin = self._weights, _REGAIN if self._let_go else 0.0
        x, y = seen_from(stance, target).tolist()
        near, far = weights.hand_nearest + margin, weights.hand_farthest - margin
        self._let_go = (walks or self._let_go) and (x < near or math.hypot(x, y) > far)
        return self._let_go


class GazeReference:
    """The reference of the view: yaw relative to the stance's heading and pitch, at limited speed.

    Args:
        weights: the robot's numbers.
        dt: control period [s].
        neck_range: farthest the neck turns to either side [rad], 0 without a neck.

    Attributes:
        yaw, pitch: [rad].
    """

    def __init__(self, weights: WholeBodyConfig, dt: float, neck_range: float) -> None:
        self._limit, self._step = weights.gaze_yaw, weights.gaze_speed * dt
        self._neck = _NECK_SHARE * neck_range
        self.yaw = self.pitch = 0.0

    def update(self, point: Array | None, hold: bool, eyes: Array, heading: float, axis: Array | None = None) -> None:
        """Turn toward a point, world frame, shape (3,); ahead if None.

        Args:
            point: what to look at.
            hold: stay.
            eyes: position of the gaze site, world frame, shape (3,) [m].
            heading: of the stance [rad].
            axis: where the view turns to the side, shape (3,): not at the eyes if they are far ahead of it.
        """
        if hold or (point is None and not self.yaw and not self.pitch):
            return
        yaw = pitch = 0.0
        if point is not None:
            (x, y, z), (eyes_x, eyes_y, eyes_z) = point.tolist(), eyes.tolist()
            turns_x, turns_y = (eyes_x, eyes_y) if axis is None else axis[:2].tolist()
            yaw = wrap(math.atan2(y - turns_y, x - turns_x) - heading)
            pitch = -math.atan2(z - eyes_z, math.hypot(x - eyes_x, y - eyes_y))
            if abs(yaw) > self._limit and yaw * self.yaw < 0:
                yaw = -yaw  # behind the robot: stay on the side it looks over already
        yaw = min(max(yaw, -self._limit), self._limit)
        pitch = min(max(pitch, _PITCH_RANGE[0]), _PITCH_RANGE[1])
        self.yaw = approach(self.yaw, yaw, self._step)
        self.pitch = approach(self.pitch, pitch, self._step)

    @property
    def torso_yaw(self) -> float:
        """How far the torso turns because the neck does not turn far enough [rad]."""
        return self.yaw - min(max(self.yaw, -self._neck), self._neck)


class PostureReference:
    """The joint posture that fills what the tasks leave free: home, or on its way back to it.

    Args:
        home: shape (nj,) [rad].
        dt: control period [s].
    """

    def __init__(self, home: Array, dt: float) -> None:
        self._home, self._step = home, _RELAX_SPEED * dt
        self.joints: Array = home.copy()

    def release_from(self, joints: Array) -> None:
        """Start from these joint angles, shape (nj,), when something that held them was released."""
        self.joints = joints.copy()

    def update(self) -> None:
        """Move back toward home."""
        _move(self.joints, self._home, self._step)

    def hold(self, joints: list[int], angles: Array) -> None:
        """Put some joints, by their indices, where somebody else wants them: at angles, shape (len(joints),) [rad]."""
        self.joints[joints] = angles


@compiled("void(f8[::1], f8[::1], f8)")
def _move(joints: Array, goal: Array, step: float) -> None:
    """Move joints toward a goal, each of shape (nj,), by at most ``step`` [rad]."""
    for joint in range(len(joints)):
        joints[joint] += min(max(goal[joint] - joints[joint], -step), step)


class ArmReference:
    """The reference of the joints of an arm that are commanded by name; they follow at limited speed.

    As that of a hand it is never far ahead of the planned joints: an arm that is in its own way pulls no harder.

    Args:
        names: of all joints of the robot.
        weights: the robot's numbers.
        dt: control period [s].

    Attributes:
        joints: those that are commanded, as indices of the arrays over joints.
        angles: theirs, shape (len(joints),) [rad].
    """

    def __init__(self, names: Sequence[str], weights: WholeBodyConfig, dt: float) -> None:
        self._index = {name: index for index, name in enumerate(names)}
        self._weights, self._dt = weights, dt
        self.joints: list[int] = []
        self.angles: Array = np.zeros(0)

    def update(self, target: ArmTarget | None, planned: Array) -> None:
        """Follow a target, or let go of the joints.

        Args:
            target: None to release the arm.
            planned: joints of the inverse kinematics, shape (nj,) [rad].
        """
        if target is None:
            self.joints, self.angles = [], np.zeros(0)
            return
        joints = [self._index[name] for name in target.joints]
        known = dict(zip(self.joints, self.angles.tolist(), strict=True))
        now = np.array([known.get(joint, planned[joint]) for joint in joints])
        fastest, lead = self._weights.arm_speed, self._weights.arm_lead
        step = (fastest if target.speed is None else min(target.speed, fastest)) * self._dt
        ahead = now + clamp(np.array(list(target.joints.values())) - now, -step, step)
        self.joints, self.angles = joints, clamp(ahead, planned[joints] - lead, planned[joints] + lead)


def _carried(point: Array, before: Array, after: Array) -> Array:
    """Return where a point, shape (3,), gets with a stance that moves; it keeps its height."""
    x, y = seen_from(before, point)
    return np.array([*ahead(after, x, y)[:2], point[2]])


def _toward(point: Array, goal: Array, step: float) -> Array:
    """Return a point moved toward another by at most ``step``, shape (3,)."""
    way = goal - point
    distance = math.sqrt(way.dot(way))
    return goal.copy() if distance <= step else np.asarray(point + way * (step / distance))


class ComHeightReference:
    """The reference of the height of the centre of mass.

    It is higher in long steps, in which the knees straighten. It rises slowly where a push has made a robot sink that
    steps: the leg that lands next would push the robot up at once, and off the ground.

    Args:
        rise: how much higher it is in the longest steps straight ahead [m].
        dt: control period [s].

    Attributes:
        height: of the centre of mass [m].
    """

    def __init__(self, rise: float, dt: float) -> None:
        self._rise, self._dt = rise, dt
        self._risen = self._rising = 0.0
        self.height = 0.0

    def reset(self, height: float) -> None:
        """Begin at a height [m]."""
        self._risen, self._rising, self.height = 0.0, 0.0, height

    def update(self, wanted: float, measured: float, *, steps: bool, stride: float = 0.0) -> float:
        """Return the reference [m].

        Args:
            wanted, measured: the height [m], wanted as a robot that stands.
            steps: whether a step is going on.
            stride: how much of the longest step straight ahead it is, in [0, 1].
        """
        pull = (self._rise * stride - self._risen) / _STRETCH_TIME - 2 * self._rising
        self._rising += self._dt / _STRETCH_TIME * pull
        self._risen += self._dt * self._rising
        after = wanted = wanted + self._risen
        if steps:
            after = max(min(wanted, measured + _SUNK), min(wanted, self.height - _SINK_SPEED * self._dt))
        self.height = min(after, self.height + _RISE_SPEED * self._dt)
        return self.height


def approach(value: float, goal: float, step: float) -> float:
    """Return ``value`` moved toward ``goal`` by at most ``step``."""
    way = goal - value
    if way > step:
        return value + step
    return value - step if way < -step else value + way
