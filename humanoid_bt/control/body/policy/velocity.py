"""From where the base is to go to the velocity that a learned walker is commanded, and whether it stands."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.planar import ahead, seen_from, wrap
from humanoid_bt.core.messages import Array, Gait
from humanoid_bt.robot.policy.policy import Policy

ARRIVED, LEAVES = (0.02, 0.035), (0.04, 0.055)
"""How near [m] and how little turned [rad] is there, and beyond what a robot that is there starts again.

Wider than those of planned footsteps: a walker that stops takes a last step of its own."""

_CLOSE = (0.025, 0.035)
"""How near [m] and how little turned [rad] one that came to rest stays; else it goes there once more."""

_MORE = 2  # times that it does so: a walker that cannot stop nearer would never stop

_SWAYS_ON = 0.1  # s that a walker that stops goes on to the side to which it sways
_SWAYS_MOST = 0.02  # m of it: one that sways far is never where it is expected
_SLIDE_SHARE = 0.4  # of what a stop ends farther than was expected that is expected of the next one
_SLIDES_MOST = 0.08  # m, rad: more is a push
_COMES_TO_REST, _FAR_OFF = 0.8, 0.15  # s in which it only starts again if it is farther off than this [m]
_NEAR = 0.5  # m within which it walks sideways and back instead of turning to where it goes
_APPROACH = 1.5  # 1/s: speed per distance
_INSIST, _INSIST_MOST = (0.6, 0.6, 0.4), (0.25, 0.25, 0.2)
"""1/s^2, and m/s and rad/s: speed ahead, aside and of the turn by the integral of what is left of each, near."""

_INSISTS_WITHIN = 0.15  # rad: a larger turn is no slow one
_TURN = 1.5  # 1/s: turn per angle, near
_TURN_FAR = 2.2  # 1/s: likewise while it walks ahead to a far place
_TURNS_ONLY = 1.2  # rad of bearing beyond which it turns on the spot
_BRAKE_AHEAD = 0.1  # m before a place at which the speed of a far approach would be zero
_NEAR_SPEED, _NEAR_SIDE = 0.5, 0.4  # m/s at most, near
_FAR_SPEED = 0.8  # m/s at most
_SLEW = 2.0  # m/s^2, rad/s^2
_THERE = 0.7  # of the arrival's bounds, within which that part of the error is left alone
_STILL_AFTER = 0.25  # s at rest after which it stands
_QUIET = 0.02  # m/s of it below which a stop is over: else a last step may come yet
_RESTS, _MOVES = 0.06, 0.12  # m/s of the centre of mass below which it rests, beyond which it does not (hysteresis)

_Motion = tuple[float, float, float]
"""Ahead, aside and of the turn."""

_NO_MOTION: _Motion = (0.0, 0.0, 0.0)


class VelocityReference:
    """Walks to places by velocity commands.

    It turns to a far place and walks ahead; near it, it walks in any direction and turns as it is to face. Within the
    bounds of arrival the command is zero; what the robot drifts then, as learned walkers do, is corrected beyond those
    at which it starts again.

    A walker that stops comes to rest somewhere else than it was told to stop, each of them in its own way: its feet
    slide back by 3 cm, or it turns by 2 degrees. That is learnt from every stop, so that it stops before or beyond the
    place; one that came to rest too far off goes once more, twice at most.

    Args:
        policy: whose commands.
        dt: time between two calls [s].

    Attributes:
        command: vx, vy [m/s] and wz [rad/s], shape (3,).
        stands: whether that is to stand.
        gait: what the legs do, as far as the command and the motion tell.
        still_for: how long it stands already [s].
    """

    def __init__(self, policy: Policy, dt: float) -> None:
        self._ranges: list[tuple[float, float]] = [(low, high) for low, high in policy.ranges.T.tolist()]
        self._limits, self._dt = policy.config.command, dt
        self.reset()

    def reset(self) -> None:
        """Stand."""
        self._say(_NO_MOTION)
        self.gait = Gait.STAND
        self.still_for = 0.0
        self._goes = self._moves = self._quiet = False
        self._stopped_for = _COMES_TO_REST  # s
        self._insists = _NO_MOTION  # m/s ahead and to the left, rad/s
        self._insists_on: Array = np.zeros(3)  # the place of which that is
        self._slides = _NO_MOTION  # farther than expected, as it stops: m ahead, m aside, rad
        self._will_slide = self._expected = self._slides  # if it stops now; when it stopped last
        self._stopped_at: Array | None = None  # while it comes to rest
        self._more = 0  # times that it may yet go once more when it rests
        self._goes_once_more = False  # now

    def _say(self, command: _Motion) -> None:
        below = self._limits.stand_below
        vx, vy, wz = command
        self.command: Array = np.array(command)
        self.stands = math.hypot(vx, vy) < below and abs(wz) < below

    def update(self, goal: Array | None, stance: Array, sways: float = 0.0) -> Array:
        """Return the velocity of this moment, shape (3,).

        Args:
            goal: where to stand: x, y [m], heading [rad], world frame; None to stand where it is.
            stance: where it is, likewise.
            sways: how fast its centre of mass moves to the left [m/s].
        """
        self._learn(stance)
        slides_ahead, slides_aside, slides_round = self._slides
        sways_on = min(max(_SWAYS_ON * sways, -_SWAYS_MOST), _SWAYS_MOST)
        self._will_slide = slides_ahead, slides_aside + sways_on, slides_round
        wanted = _NO_MOTION
        if goal is None:
            self._goes, self._stopped_at = False, None
            self._insists = _NO_MOTION
        else:
            wanted = self._toward(goal, stance)
        if any(wanted):
            step, before = _SLEW * self._dt, self.command.tolist()
            vx, vy, wz = [now + min(max(speed - now, -step), step) for now, speed in zip(before, wanted, strict=True)]
            self._say((vx, vy, wz))
            self._stopped_for = 0.0
        else:  # zero is the stop: the policy brakes by itself
            self._say(_NO_MOTION)
            self._stopped_for += self._dt
        return self.command

    def note(self, com_speed: float, dt: float) -> None:
        """Take how fast the centre of mass moves [m/s], once a control period [s]."""
        self._moves = com_speed > (_RESTS if self._moves else _MOVES)
        if not self.stands:
            self.gait, self.still_for = Gait.STEP, 0.0
        elif self._moves:
            self.gait, self.still_for = Gait.SETTLE, 0.0
        else:
            self.still_for += dt
            if self.still_for > _STILL_AFTER and self._stopped_at is None:
                self.gait = Gait.STAND
        self._quiet = com_speed < _QUIET and self.still_for > _STILL_AFTER

    def goes(self, goal: Array, stance: Array) -> bool:
        """Return whether it goes to a place now, and is not there: farther than where it stays once it has arrived."""
        if self._goes:
            return _is_beyond(ARRIVED, goal, stance)
        if self._stopped_for < _COMES_TO_REST and not self._quiet:
            return math.dist(goal[:2].tolist(), stance[:2].tolist()) > _FAR_OFF
        return _is_beyond(_CLOSE if self._goes_once_more else LEAVES, goal, stance)

    def _learn(self, stance: Array) -> None:
        """Learn from a stop how far it slides, once it is over."""
        self._goes_once_more = False
        if self._stopped_at is None or (self._stopped_for < _COMES_TO_REST and not self._quiet):
            return
        self._goes_once_more = self._more > 0
        slid = *seen_from(self._stopped_at, stance).tolist(), wrap(stance.item(2) - self._stopped_at.item(2))
        self._stopped_at = None
        if max(map(abs, slid)) < _SLIDES_MOST:
            x, y, yaw = [
                known + _SLIDE_SHARE * (new - expected)
                for known, new, expected in zip(self._slides, slid, self._expected, strict=True)
            ]
            self._slides = x, y, yaw

    def _toward(self, goal: Array, stance: Array) -> _Motion:
        limits = self._limits
        before, at = self._goes, stance
        if _is_beyond(LEAVES, goal, self._insists_on):
            self._insists_on, self._insists = goal, _NO_MOTION
        if before:
            stance = ahead(stance, *self._will_slide)
        self._goes = self.goes(goal, stance)
        if self._goes and not before:
            self._more, self._stopped_at = _MORE if _is_beyond(LEAVES, goal, stance) else self._more - 1, None
        if before and not self._goes:
            self._stopped_at, self._expected = at, self._will_slide
        if not self._goes:
            self._insists = _NO_MOTION
            return _NO_MOTION
        x, y = seen_from(stance, goal).tolist()
        distance, turn = math.hypot(x, y), wrap(goal.item(2) - stance.item(2))
        if distance > _NEAR:
            self._insists = _NO_MOTION
            bearing = math.atan2(y, x)
            fastest = min(_FAR_SPEED, _APPROACH * (distance - _BRAKE_AHEAD))
            speed = fastest * max(0.0, math.cos(bearing)) ** 2 if abs(bearing) < _TURNS_ONLY else 0.0
            return self._in_range(speed, 0.0, _TURN_FAR * bearing)
        speed = 0.0
        if distance > _THERE * ARRIVED[0]:
            speed = max(limits.slowest, min(_APPROACH * distance, _NEAR_SPEED))
        rate = _TURN * turn
        if abs(turn) > _THERE * ARRIVED[1]:
            rate = math.copysign(max(abs(rate), limits.slowest_turn), turn)
        share = speed / distance if distance else 0.0
        # A walker that leans lags behind its command, and one that is to turn slowly may not turn at all:
        left = (x, y, turn if abs(turn) < _INSISTS_WITHIN else 0.0)
        vx, vy, wz = self._insists = self._insist(left)
        aside = min(max(share * y, -_NEAR_SIDE), _NEAR_SIDE)
        return self._in_range(share * x + vx, aside + vy, rate + wz)

    def _insist(self, left: _Motion) -> _Motion:
        """Return the speeds by which it insists, after a period with so much left of each."""
        x, y, yaw = [
            min(max(before + rate * self._dt * way, -most), most)
            for before, rate, way, most in zip(self._insists, _INSIST, left, _INSIST_MOST, strict=True)
        ]
        return x, y, yaw

    def _in_range(self, *wanted: float) -> _Motion:
        """Return a velocity as far as the policy can be commanded it."""
        vx, vy, wz = [min(max(one, low), high) for one, (low, high) in zip(wanted, self._ranges, strict=True)]
        return vx, vy, wz


def _is_beyond(bounds: tuple[float, float], goal: Array, stance: Array) -> bool:
    """Return whether a place is farther away, or turned more, than bounds [m, rad]."""
    near, little = bounds
    (x, y, yaw), (at_x, at_y, heading) = goal.tolist(), stance.tolist()
    return math.hypot(x - at_x, y - at_y) > near or abs(wrap(yaw - heading)) > little
