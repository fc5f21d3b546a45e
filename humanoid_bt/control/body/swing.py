"""The swing foot: a minimum-jerk path that is retargeted at every step of control, and step adjustment."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.foot_roll import FootRoll
from humanoid_bt.control.body.footsteps import SIGN
from humanoid_bt.control.body.planar import seen_from
from humanoid_bt.control.body.step_timing import Axis, Pace, best_place, best_time, miss
from humanoid_bt.core.compiled import compiled, inlined
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.core.turns import product, to_vector, turned
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
_FASTEST = 2.0  # m/s, likewise, of one that gets as far as it can
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
        missed: from where the DCM should be when the foot lands to where it will be, wherever in its reach that is,
            shape (2,), world frame [m].
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
        self._ankle = np.array([_ANKLE_SHARE * half for half in sole.bears])
        self._steps = round(gait.single_support / dt)
        self._start, self._support = start.copy(), support.copy()  # as they are now
        self._planned, self._dcm_end = seen_from(support, foothold), seen_from(support, dcm_end)
        self._bounds = self._reach(gait)
        self._flown = 0.0  # s
        self._place = self._planned.copy()
        self._motion = np.zeros((2, 3))  # position, velocity, acceleration along each axis
        self._motion[:, 0] = start[:2]
        self.pose: Array = start.copy()
        self._footings = footings[0].copy(), footings[1].copy()
        self.footing: Array = footings[0].copy()
        self._roll = FootRoll(gait, sole, dt, start, foothold)
        self.rolled: Array = np.zeros(3)
        self.target: Array = foothold.copy()
        self.progress = 0.0
        self.rate = 1.0
        self.missed: Array = np.zeros(2)

    def update(self, elapsed: float, dcm: Array, zmp: Array, *, stops: bool = False) -> None:
        """Move the foot for one control period.

        Args:
            elapsed: control periods since lift-off.
            dcm: measured DCM, shape (2,), world frame [m].
            zmp: reference of the ZMP, shape (2,), world frame [m].
            stops: whether the robot is being stopped: the foot comes down flat.
        """
        gait, dt = self._gait, self._dt
        self.progress = (elapsed + 1) / self._steps
        if self.progress < gait.adjust_until:
            remaining = max((self._steps - elapsed) * dt, dt)
            soonest = min(max(gait.quickest_step - self._flown, remaining / _HURRY_MAX), remaining)
            self.rate = _adjust(
                self._place, self.target, self.missed, dcm, zmp, self.pose, self._support, self._planned, self._dcm_end,
                self._bounds, self._ankle, self._omega, remaining, soonest, dt,
            )  # fmt: skip
        self._flown += dt
        self.pose, self.footing = np.empty(3), np.empty(3)
        _move(
            self.pose, self.footing, self._motion, self.target, self._start, self._support, *self._footings,
            self.progress, (1.0 - self.progress) * gait.single_support / self.rate, gait.lift, dt,
        )  # fmt: skip
        moved, missed = math.dist(self._place.tolist(), self._planned.tolist()), math.hypot(*self.missed.tolist())
        self.rolled = self._roll.footing(
            self.progress, self.pose.item(2), moved=moved, missed=missed, rate=self.rate, stops=stops
        )
        self.footing += self.rolled

    @property
    def stride(self) -> float:
        """How much of the longest step straight ahead it is, in [0, 1]; less if it turns or is disturbed."""
        return self._roll.stride

    def _reach(self, gait: GaitConfig) -> Array:
        """Return least and most of each coordinate of the foothold, seen from the other foot, shape (2, 2) [m]."""
        x, y = self._planned.tolist()
        sign = SIGN[self.side]
        along = max(x - gait.adjust_forward, REACH_FORWARD[0]), min(x + gait.adjust_forward, REACH_FORWARD[1])
        near = max(sign * y - gait.adjust_sideways, gait.separation_min)
        far = min(sign * y + gait.adjust_sideways, gait.separation_max)
        return np.array([along, (near, far) if sign > 0 else (-far, -near)])


@inlined
def _seen_from(pose: Array, x: float, y: float) -> tuple[float, float]:
    """Return a point's plane coordinates as seen from a pose: ``planar.seen_from``."""
    x, y = x - pose[0], y - pose[1]
    cos, sin = math.cos(-pose[2]), math.sin(-pose[2])
    return cos * x - sin * y, sin * x + cos * y


@inlined
def _axis(
    i: int,
    tau: float,
    here: float,
    stands_on: float,
    foot: float,
    planned: Array,
    dcm_end: Array,
    bounds: Array,
    ankle: Array,
) -> Axis:
    """Return what decides about a coordinate of the foothold."""
    error = (here - stands_on) * tau + stands_on - dcm_end[i]
    taken = min(max(error / max(tau - 1, 1e-6), -ankle[i]), ankle[i])
    pressure = stands_on + taken
    return Axis(pressure, here - pressure, planned[i], dcm_end[i] - planned[i], bounds[i, 0], bounds[i, 1], foot)


@compiled(
    "f8(f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[:, ::1], f8[::1],"
    " f8, f8, f8, f8)"
)
def _adjust(
    place: Array,
    target: Array,
    missed: Array,
    dcm: Array,
    zmp: Array,
    pose: Array,
    support: Array,
    planned: Array,
    dcm_end: Array,
    bounds: Array,
    ankle: Array,
    omega: float,
    remaining: float,
    soonest: float,
    dt: float,
) -> float:
    """Move the foothold by where the DCM would be at touchdown; return how fast the swing is to run.

    All of the DCM's error that the ankle can take out counts as taken out.

    Args:
        place, target: the foothold, seen from the support foot, shape (2,), and in the world, shape (3,); are moved.
        missed: is written: by what the foot will miss where it should land for the DCM, shape (2,), world frame [m].
        dcm, zmp: as in :meth:`Swing.update`.
        pose, support: of the swinging and of the other foot, shape (3,), world frame.
        planned, dcm_end: foothold and DCM at touchdown as planned, seen from the support foot, shape (2,).
        bounds: of the foothold, likewise, shape (2, 2).
        ankle: how far it moves the pressure along and across the foot, shape (2,) [m].
        omega: [1/s].
        remaining, soonest: time until touchdown, as planned and at least [s].
        dt: control period [s].
    """
    tau = math.exp(omega * remaining)
    here, pressure = _seen_from(support, dcm[0], dcm[1]), _seen_from(support, zmp[0], zmp[1])
    foot = _seen_from(support, pose[0], pose[1])
    ahead = _axis(0, tau, here[0], pressure[0], foot[0], planned, dcm_end, bounds, ankle)
    aside = _axis(1, tau, here[1], pressure[1], foot[1], planned, dcm_end, bounds, ankle)
    pace = Pace(tau, omega, _HURRY_SPEED)
    best = best_time((ahead, aside), math.exp(omega * soonest), tau, pace)
    follow = min(1.0, dt / _ADJUST_TIME)
    place[0] += follow * (best_place(ahead, best, pace) - place[0])
    place[1] += follow * (best_place(aside, best, pace) - place[1])
    cos, sin = math.cos(support[2]), math.sin(support[2])
    fastest = Pace(tau, omega, _FASTEST)
    off_x, off_y = miss(ahead, best, fastest), miss(aside, best, fastest)
    missed[0], missed[1] = cos * off_x - sin * off_y, sin * off_x + cos * off_y
    target[0] = support[0] + cos * place[0] - sin * place[1]
    target[1] = support[1] + sin * place[0] + cos * place[1]
    return remaining * omega / max(math.log(best), 1e-6)


@inlined
def _go_on(motion: Array, error: float, remaining: float, dt: float) -> None:
    """Go on for ``dt`` on the minimum-jerk path that ends at rest after ``remaining`` (Hoff and Arbib 1993).

    Evaluated exactly: near the end an explicit step of the jerk overshoots without bound.
    """
    x, v, a = motion[0], motion[1], motion[2]
    if remaining > dt:
        h = remaining
        cubic = (20 * error - 12 * v * h - 3 * a * h**2) / (2 * math.pow(h, 3.0))
        quartic = (-30 * error + 16 * v * h + 3 * a * h**2) / (2 * math.pow(h, 4.0))
        quintic = (12 * error - 6 * v * h - a * h**2) / (2 * math.pow(h, 5.0))
        motion[0] = x + dt * (v + dt * (a / 2 + dt * (cubic + dt * (quartic + dt * quintic))))
        motion[1] = v + dt * (a + dt * (3 * cubic + dt * (4 * quartic + dt * 5 * quintic)))
        motion[2] = a + dt * (6 * cubic + dt * (12 * quartic + dt * 20 * quintic))
    else:
        motion[0], motion[1], motion[2] = x + _LATE_SHARE * error, 0.0, 0.0
    if abs(motion[0] - x) > _SPEED_MAX * dt:
        speed = math.copysign(_SPEED_MAX, motion[0] - x)
        motion[0], motion[1], motion[2] = x + speed * dt, speed, 0.0


@compiled("void(f8[::1], f8[::1], f8[:, ::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8, f8, f8, f8)")
def _move(
    pose: Array,
    footing: Array,
    motion: Array,
    target: Array,
    start: Array,
    support: Array,
    before: Array,
    ground: Array,
    progress: float,
    left: float,
    lift: float,
    dt: float,
) -> None:
    """Move the foot for one control period.

    Args:
        pose, footing: are written, as in :class:`Swing`.
        motion: is moved: position, velocity, acceleration along each axis, shape (2, 3).
        target, start, support: the foothold, where the foot was lifted, and the other foot: poses, shape (3,).
        before, ground: height and tilt of the foot when it was lifted, and of the other one, shape (3,) [m, rad].
        progress: share of the swing that is over.
        left: time until touchdown [s].
        lift: [m].
        dt: [s].
    """
    remaining = max(left - _ARRIVE_EARLY, 0.0)
    for axis in range(2):
        _go_on(motion[axis], target[axis] - motion[axis, 0], remaining, dt)
    share = min(1.0, progress / _LAND_FROM)
    turn = math.pow(share, 3.0) * (10 - 15 * share + 6 * share**2)
    rise = ground[1] * (target[1] - support[1]) - ground[2] * (target[0] - support[0])  # if it is as steep there
    for i in range(3):
        after = ground[i] + (rise if i == 0 else 0.0)
        footing[i] = before[i] + turn * (after - before[i])
    if share < 1.0:
        footing[0] += lift * 0.5 * (1 - math.cos(2 * math.pi * math.pow(share, _LIFT_EARLY)))
    else:
        footing[0] -= _LAND_DEPTH * (progress - _LAND_FROM) / (1 - _LAND_FROM)
    off = (target[2] - start[2] + math.pi) % (2 * math.pi) - math.pi
    pose[0], pose[1], pose[2] = motion[0, 0], motion[1, 0], start[2] + off * turn


class TiltCompensation:
    """Keeps the swing foot level with the ground although the base tilts away from its reference.

    The swing foot's reference is turned with the base's error in the world; after touchdown the correction decays,
    because a jump of a target in contact is an impact.

    Attributes:
        correction: how each sole is shifted [m], and turned about its place [rad], world frame, shape (6,).
    """

    _RISE, _DECAY = 0.02, 0.12  # s
    _FADE_IN = 0.3  # share of the swing
    _LIMIT = 0.3  # m and rad, of each coordinate of the correction

    def __init__(self, dt: float) -> None:
        self._dt, self._decay = dt, math.exp(-dt / self._DECAY)
        self.correction: dict[Side, Array] = {side: np.zeros(6) for side in SIDES}

    def update(self, swing: Swing | None, base_measured: Array, base_reference: Array) -> None:
        """Follow the base's error; ``base_*`` are poses (x, y, z, qw, qx, qy, qz), world frame."""
        for side in SIDES:
            if swing is not None and swing.side == side:
                weight = min(1.0, max(0.0, swing.progress) / self._FADE_IN)
                share = min(1.0, self._dt / self._RISE)
                _follow_error(
                    self.correction[side], swing.pose, swing.footing, base_measured, base_reference,
                    weight, share, self._LIMIT,
                )  # fmt: skip
            else:
                _fade(self.correction[side], self._decay)


@compiled("void(f8[::1], f8)")
def _fade(correction: Array, share: float) -> None:
    """Leave a share of a correction, shape (6,)."""
    for axis in range(len(correction)):
        correction[axis] *= share


@compiled("void(f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8, f8, f8)")
def _follow_error(
    correction: Array,
    pose: Array,
    footing: Array,
    measured: Array,
    reference: Array,
    weight: float,
    share: float,
    limit: float,
) -> None:
    """Bring a sole's correction nearer to what leads the base, and the sole with it, from one pose to another.

    Args:
        correction: shape (6,).
        pose, footing: how it is to be, shape (3,): far from the world's origin a turn about that would be a long way.
        measured, reference: poses of the base, shape (7,).
        weight: of what leads from the first to the second.
        share: of the difference by which it comes nearer.
        limit: of each coordinate of what it is to follow.
    """
    sole = pose[0], pose[1], footing[0]
    turn = product(
        (reference[3], reference[4], reference[5], reference[6]),
        (measured[3], -measured[4], -measured[5], -measured[6]),
    )
    place = turned(turn, (sole[0] - measured[0], sole[1] - measured[1], sole[2] - measured[2]))
    about = to_vector(turn)
    for axis in range(3):
        goal = weight * min(max(reference[axis] + place[axis] - sole[axis], -limit), limit)
        correction[axis] += share * (goal - correction[axis])
        goal = weight * min(max(about[axis], -limit), limit)
        correction[3 + axis] += share * (goal - correction[3 + axis])
