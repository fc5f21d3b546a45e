"""The swing foot: a minimum-jerk path that is retargeted at every step of control, and step adjustment."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.foot_roll import FootRoll
from humanoid_bt.control.body.footsteps import SIGN
from humanoid_bt.control.body.planar import ahead, seen_from, wrap
from humanoid_bt.control.body.step_timing import Axis, best_time
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.core.turns import logarithm, product, turned
from humanoid_bt.robot.config import GaitConfig, SoleConfig

_ARRIVE_EARLY = 0.02  # s before touchdown at which the foot is over its foothold
_LATE_SHARE = 0.5  # of what is still missing then, in each control period
_SPEED_MAX = 4.0  # m/s along each axis, of the foot's reference: a foothold that moves late is not reached
_LAND_FROM = 0.93  # share of the swing after which the foot only goes down
_LIFT_EARLY = 0.7  # power of the share: it goes up quickly and comes down slowly, wherever the ground is
_LAND_DEPTH = 0.004  # m below the ground that it aims at, so that it does land
_ADJUST_TIME = 0.03  # s, low-pass of the adjustment
_ANKLE_SHARE = 0.5  # of the DCM error that the ankle can still take out
_HURRY_MAX = 2.5  # how much faster than planned a step may go
_HURRY_SPEED = 1.1  # m/s of a foot that hurries, on average: more is planned than it gets done
REACH_FORWARD = (-0.35, 0.45)
"""Of a foothold, seen from the support foot [m]."""


class Swing:
    """One swing of a foot.

    Args:
        gait, sole: the robot's numbers.
        omega: [1/s].
        dt: control period [s].
        side: the foot that swings.
        start: its pose at lift-off, shape (3,), world frame.
        foothold: the planned pose, shape (3,), world frame.
        support: pose of the other foot, shape (3,), world frame.
        footings: height and tilt of this foot at lift-off and of the other one, each of shape (3,) [m, rad].
        dcm_end: planned DCM at touchdown, shape (2,), world frame [m].

    Attributes:
        pose: reference of the sole, shape (3,), world frame.
        footing: reference of its height and of its tilt about the world's x and y, shape (3,) [m, rad].
        rolled: how much of ``footing`` is the roll from heel to toe, shape (3,) [m, rad].
        target: the foothold as adjusted, shape (3,).
        progress: share of the swing that is over, in [0, 1].
        rate: how fast the swing runs; above 1 when the DCM runs away and the foot must hurry.
    """

    def __init__(
        self,
        gait: GaitConfig,
        sole: SoleConfig,
        omega: float,
        dt: float,
        *,
        side: Side,
        start: Array,
        foothold: Array,
        support: Array,
        footings: tuple[Array, Array],
        dcm_end: Array,
    ) -> None:
        self._gait, self._omega, self._dt, self.side = gait, omega, dt, side
        self._ankle = [_ANKLE_SHARE * half for half in sole.bears]
        self._steps = round(gait.single_support / dt)
        self._start, self._support = start, support
        self._planned, self._dcm_end = seen_from(support, foothold), seen_from(support, dcm_end)
        self._bounds = self._reach(gait)
        self._flown = 0.0  # s
        self._place = self._planned.tolist()
        self._motion = [[float(start[0]), 0.0, 0.0], [float(start[1]), 0.0, 0.0]]  # position, velocity, acceleration
        self.pose: Array = start.copy()
        self._footings = footings
        self.footing: Array = footings[0].copy()
        self._roll = FootRoll(gait, sole, start, foothold)
        self.rolled: Array = np.zeros(3)
        self.target: Array = foothold.copy()
        self.progress = 0.0
        self.rate = 1.0

    def update(self, elapsed: float, dcm: Array, zmp: Array) -> None:
        """Move the foot for one control period.

        Args:
            elapsed: control periods since lift-off.
            dcm: measured DCM, shape (2,), world frame [m].
            zmp: reference of the ZMP, shape (2,), world frame [m].
        """
        self.progress = (elapsed + 1) / self._steps
        if self.progress < self._gait.adjust_until:
            self._adjust(max((self._steps - elapsed) * self._dt, self._dt), dcm, zmp)
        self._flown += self._dt
        self._move()

    def _adjust(self, remaining: float, dcm: Array, zmp: Array) -> None:
        """Move the foothold, and hurry, by where the DCM would be at touchdown."""
        planned_tau = math.exp(self._omega * remaining)
        axes = self._axes(planned_tau, seen_from(self._support, dcm), seen_from(self._support, zmp))
        soonest = min(max(self._gait.quickest_step - self._flown, remaining / _HURRY_MAX), remaining)
        tau = best_time(
            axes, planned_tau, math.exp(self._omega * soonest), planned_tau, omega=self._omega, speed=_HURRY_SPEED
        )
        self.rate = remaining * self._omega / max(math.log(tau), 1e-6)
        follow, reach = min(1.0, self._dt / _ADJUST_TIME), _HURRY_SPEED * math.log(tau) / self._omega
        for i, axis in enumerate(axes):
            self._place[i] += follow * (axis.place(tau, reach) - self._place[i])
        self.target[:2] = ahead(self._support, *self._place)[:2]

    def _axes(self, tau: float, dcm: Array, zmp: Array) -> list[Axis]:
        """Return what decides about the foothold, with all of the DCM's error that the ankle can take out taken out."""
        axes: list[Axis] = []
        foot = seen_from(self._support, self.pose)
        for i, (least, most) in enumerate(self._bounds):
            here, stands_on, end = dcm.item(i), zmp.item(i), self._dcm_end.item(i)
            error = (here - stands_on) * tau + stands_on - end
            ankle = min(max(error / max(tau - 1, 1e-6), -self._ankle[i]), self._ankle[i])
            pressure = stands_on + ankle
            planned = self._planned.item(i)
            axes.append(Axis(pressure, here - pressure, planned, end - planned, least, most, foot.item(i)))
        return axes

    def _reach(self, gait: GaitConfig) -> list[tuple[float, float]]:
        """Return least and most of each coordinate of the foothold, seen from the other foot [m]."""
        x, y = self._planned.tolist()
        sign = SIGN[self.side]
        along = max(x - gait.adjust_forward, REACH_FORWARD[0]), min(x + gait.adjust_forward, REACH_FORWARD[1])
        near = max(sign * y - gait.adjust_sideways, gait.separation_min)
        far = min(sign * y + gait.adjust_sideways, gait.separation_max)
        return [along, (near, far) if sign > 0 else (-far, -near)]

    def _move(self) -> None:
        dt = self._dt
        remaining = max((1.0 - self.progress) * self._gait.single_support / self.rate - _ARRIVE_EARLY, 0.0)
        for axis, motion in enumerate(self._motion):
            error = float(self.target[axis]) - motion[0]
            if remaining > dt:
                after = _minimum_jerk(motion, error, remaining, dt)
            else:
                after = [motion[0] + _LATE_SHARE * error, 0.0, 0.0]
            if abs(after[0] - motion[0]) > _SPEED_MAX * dt:
                speed = math.copysign(_SPEED_MAX, after[0] - motion[0])
                after = [motion[0] + speed * dt, speed, 0.0]
            motion[:] = after
        share = min(1.0, self.progress / _LAND_FROM)
        turn = share**3 * (10 - 15 * share + 6 * share**2)
        before, support = self._footings
        after = support + np.array([self._rise(), 0.0, 0.0])
        self.footing = before + turn * (after - before)
        if share < 1.0:
            self.footing[0] += self._gait.lift * 0.5 * (1 - math.cos(2 * math.pi * share**_LIFT_EARLY))
        else:
            self.footing[0] -= _LAND_DEPTH * (self.progress - _LAND_FROM) / (1 - _LAND_FROM)
        yaw = self._start[2] + wrap(self.target[2] - self._start[2]) * turn
        self.pose = np.array([self._motion[0][0], self._motion[1][0], yaw])
        moved = math.dist(self._place, self._planned.tolist())
        self.rolled = self._roll.footing(self.progress, yaw, moved)
        self.footing += self.rolled

    def _rise(self) -> float:
        """Return how much higher the ground is at the foothold, if it is as steep as under the other foot."""
        x, y = self.target[:2] - self._support[:2]
        _, roll, pitch = self._footings[1]
        return float(roll * y - pitch * x)


def _minimum_jerk(motion: list[float], error: float, remaining: float, dt: float) -> list[float]:
    """Go on for ``dt`` on the minimum-jerk path that ends at rest after ``remaining`` (Hoff and Arbib 1993).

    Evaluated exactly: near the end an explicit step of the jerk overshoots without bound.
    """
    position, velocity, acceleration = motion
    h, v, a = remaining, velocity, acceleration
    cubic = (20 * error - 12 * v * h - 3 * a * h**2) / (2 * h**3)
    quartic = (-30 * error + 16 * v * h + 3 * a * h**2) / (2 * h**4)
    quintic = (12 * error - 6 * v * h - a * h**2) / (2 * h**5)
    return [
        position + dt * (v + dt * (a / 2 + dt * (cubic + dt * (quartic + dt * quintic)))),
        v + dt * (a + dt * (3 * cubic + dt * (4 * quartic + dt * 5 * quintic))),
        a + dt * (6 * cubic + dt * (12 * quartic + dt * 20 * quintic)),
    ]


class TiltCompensation:
    """Keeps the swing foot level with the ground although the base tilts away from its reference.

    The swing foot's reference is turned with the base's error in the world; after touchdown the correction decays,
    because a jump of a target in contact is an impact.

    Attributes:
        twist: correction of each foot, as a twist in world coordinates, shape (6,).
    """

    _RISE, _DECAY = 0.02, 0.12  # s
    _FADE_IN = 0.3  # share of the swing
    _LIMIT = 0.3  # m and rad, of each coordinate of the twist

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self.twist: dict[Side, Array] = {side: np.zeros(6) for side in SIDES}

    def update(self, swing: Swing | None, base_measured: Array, base_reference: Array) -> None:
        """Follow the base's error; ``base_*`` are poses (x, y, z, qw, qx, qy, qz), world frame."""
        for side in SIDES:
            if swing is not None and swing.side == side:
                weight = min(1.0, max(0.0, swing.progress) / self._FADE_IN)
                share = min(1.0, self._dt / self._RISE)
                _follow_error(self.twist[side], base_measured, base_reference, weight, share, self._LIMIT)
            else:
                self.twist[side] *= math.exp(-self._dt / self._DECAY)


@compiled("void(f8[::1], f8[::1], f8[::1], f8, f8, f8)")
def _follow_error(twist: Array, measured: Array, reference: Array, weight: float, share: float, limit: float) -> None:
    """Bring a twist nearer to the one that leads from one pose to another.

    Args:
        twist: shape (6,).
        measured, reference: poses, shape (7,).
        weight: of what leads from the first to the second.
        share: of the difference by which it comes nearer.
        limit: of each coordinate of what it is to follow.
    """
    turn = product(
        (reference[3], reference[4], reference[5], reference[6]),
        (measured[3], -measured[4], -measured[5], -measured[6]),
    )
    x, y, z = turned(turn, (measured[0], measured[1], measured[2]))
    way, about = logarithm((reference[0] - x, reference[1] - y, reference[2] - z), turn)
    for axis in range(3):
        goal = weight * min(max(way[axis], -limit), limit)
        twist[axis] += share * (goal - twist[axis])
        goal = weight * min(max(about[axis], -limit), limit)
        twist[3 + axis] += share * (goal - twist[3 + axis])
