"""Put both hands to the sides of something."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from humanoid_bt import (
    SIDES,
    Improving,
    Lasting,
    PerceptName,
    Side,
    Skill,
    Status,
    Steady,
    of_gaze,
    param,
    result,
)

_WIDER = 0.08  # m beside it that the hands pass on their way, on either side
_OPEN = 0.03  # m from there, and
_OPEN_TURN = 0.25  # rad, at which they close in
_FACING_IT = (0.0, 1.0, 0.0, 0.0)  # the other palm's frame, fingers alike, palm facing: half a turn about the fingers


class TouchWithBoth(Skill):
    """Stand and bring both palms to the left and the right side of the target, facing each other.

    The hands pass beside the target and then close in, the right one led by the left one. Waits for a steady base
    before it moves them, half a minute at most. Fails if the target was never seen or is gone, or if a hand does not
    get there: it does not walk. Then it says what keeps it. Fails, too, if the hands were there and do not stay long
    enough, within five times the hold and the patience.
    """

    resources = ("left_hand", "right_hand", "gaze")
    bounded = True  # by its patience and its hold

    target: PerceptName = param(doc="Percept in the middle between the palms.")
    width: float = param(unit="m", above=0, maximum=0.6, doc="How wide the thing is, from side to side.")
    clearance: float = param(0.03, unit="m", minimum=0, maximum=10, doc="Of each palm's middle from the side.")
    tolerance: float = param(0.01, unit="m", above=0, doc="There when both palms are this close.")
    turn_tolerance: float = param(0.05, unit="rad", above=0, doc="There when both are turned this close.")
    hold: float = param(0.5, unit="s", minimum=0, doc="How long they must stay there.")
    patience: float = param(2.0, unit="s", above=0, doc="Fails when they come no nearer for this long.")
    smoothing: float = param(0.4, unit="s", minimum=0, doc="Low-pass time of the target's position.")
    speed: float | None = param(None, unit="m/s", minimum=0.005, doc="At most this fast; default: as the robot can.")
    look: bool = param(True, doc="Look at the target, too.")

    hand_error: float = result(unit="m", doc="Of the palm that is farther from its place.")
    turn_error: float = result(unit="rad", doc="Of the palm that is turned farther from it.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return both hands, and the gaze if it is to look."""
        return of_gaze(cls.resources, values["look"])

    def initialise(self) -> None:
        """Begin beside the target."""
        self._closing = self._steady = False
        self._place = Steady(self.smoothing)
        self._held = Lasting(self.hold, self.patience)
        self._begin()

    def _begin(self) -> None:
        self._error = Improving(self.patience, step=0.005)
        self._turn = Improving(self.patience, step=0.02)

    def update(self) -> Status:
        """Wait for a steady base, then bring the palms beside the target, then to it."""
        state, track = self.robot.state, self.robot.track(self.target)
        if track is None or track.gone:
            return self.fail(self.robot.why_unseen(self.target))
        if self.look:
            self.robot.look_at(track.position_world)
        for side in SIDES:
            if side not in state.hands:
                return self.fail(f"the robot has no {side} hand")
        self._steady = self._steady or state.base_settled
        if not self._steady:
            return self.await_rest("waiting for a steady base")
        return self._bring(self._place.update(track.position_world, track.stamp))

    def _bring(self, middle: np.ndarray) -> Status:
        now = self.robot.clock.now()
        errors, turns = self._move(middle)
        far, askew = max(SIDES, key=errors.__getitem__), max(SIDES, key=turns.__getitem__)
        self.hand_error, self.turn_error = errors[far], turns[askew]
        if not self._closing and self.hand_error < _OPEN and self.turn_error < _OPEN_TURN:
            self._closing = True
            self._begin()
            return self.running("closing in")
        there = self._closing and self.hand_error < self.tolerance and self.turn_error < self.turn_tolerance
        if self._held.update(there, now):
            return self.succeed(f"both hands at {self.target}, {self.hand_error * 100:.1f} cm off")
        if self._held.hopeless:
            return self.fail(f"the hands do not stay at {self.target} for {self.hold:g} s")
        if there:
            self._error.arrived(sum(errors.values()))
            self._turn.arrived(self.turn_error)
            return self.running("holding")
        return self._go_on(sum(errors.values()), far, askew, now)

    def _go_on(self, apart: float, far: Side, askew: Side, now: float) -> Status:
        """Go on while it helps: one hand may wait for the other."""
        if touched := self.robot.touched("left") or self.robot.touched("right"):
            return self.fail(touched)
        nearer, turns = self._error.update(apart, now), self._turn.update(self.turn_error, now)
        near = self.tolerance if self._closing else _OPEN
        if not nearer and not (turns and self.turn_error > self.turn_tolerance):
            if self.hand_error > near:
                return self.fail(self.robot.why_no_nearer(far, self.hand_error))
            return self.fail(self.robot.why_not_turned(askew, self._turn.best))
        doing = "closing in" if self._closing else "going beside it"
        return self.running(f"{doing}: {self.hand_error * 100:.0f} cm away")

    def _move(self, middle: np.ndarray) -> tuple[dict[Side, float], dict[Side, float]]:
        """Move the left palm to its side of a place, shape (3,), and the right one so that it faces it.

        Returns:
            how far the palms are from there [m], and how far they are turned from it [rad].
        """
        x, y, _ = self.robot.state.stance
        heading = math.atan2(middle[1] - y, middle[0] - x)
        ahead = np.array([math.cos(heading), math.sin(heading), 0.0])
        left = np.array([-ahead[1], ahead[0], 0.0])
        out = self.width / 2 + self.clearance + (0.0 if self._closing else _WIDER)
        frames = {side: _frame(ahead, facing) for side, facing in zip(SIDES, (-left, left), strict=True)}
        self.robot.move_hand("left", middle + out * left, frames["left"], speed=self.speed)
        self.robot.move_hand("right", (0.0, 0.0, 2 * out), _FACING_IT, relative=True, speed=self.speed)
        palms = {side: self.robot.pose(f"{side}_palm") for side in SIDES}
        places = {"left": middle + out * left, "right": middle - out * left}
        errors = {side: float(np.linalg.norm(palms[side].position - places[side])) for side in SIDES}
        return errors, {side: _angle(palms[side].rotation, frames[side]) for side in SIDES}


def _frame(fingers: np.ndarray, facing: np.ndarray) -> np.ndarray:
    """Return the rotation matrix of a palm, shape (3, 3), of two unit vectors across each other."""
    return np.column_stack([fingers, np.cross(facing, fingers), facing])


def _angle(one: np.ndarray, other: np.ndarray) -> float:
    """Return the angle between two rotation matrices [rad]."""
    return math.acos(max(-1.0, min(1.0, (float(np.sum(one * other)) - 1) / 2)))
