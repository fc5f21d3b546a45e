"""Touch something, and press against it."""

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from humanoid_bt import Gait, Lasting, Skill, Status, of_hand, param, result

_BEGINS = 0.55  # of the robot's reach: how far ahead of it the palm begins
_ASIDE = 0.35  # of its reach: how far to the side of the hand
_NEAR = 0.02  # m from there, where its way begins
_BEYOND = 0.1  # m that the target of a palm lies beyond its way: it goes all of it, and has something to press with
_SPEED = 0.1  # m/s of it on its way
_TOUCHES = 0.2  # s that something pushes it, for it to touch something
_WAYS = {
    "ahead": (1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "right": (0.0, -1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0),
}


class Touch(Skill):
    """Stand, move a palm along a direction until it touches something, and press there with a force for a time.

    The palm begins in front of the robot, on the side of the hand. Waits for a steady base before it moves it, half a
    minute at most. The body leans against what the palm presses on. Fails if the palm does not get there, if nothing is
    there to touch, if the arm has to yield, if what it touches gives way, or if it pushes the robot off its feet: it
    does not walk.
    """

    resources = ("left_hand", "right_hand")
    bounded = True  # by its patience

    hand: Literal["left", "right"] = param("right", doc="Which hand.")
    direction: Literal["ahead", "left", "right", "up", "down"] = param("ahead", doc="Where to, as the robot stands.")
    height: float | None = param(
        None,
        unit="m",
        above=0,
        maximum=10,
        doc="Palm this far above the floor as it begins; default: three quarters of the eyes'.",
    )
    distance: float = param(0.25, unit="m", above=0, maximum=10, doc="Farthest that the palm moves.")
    force: float = param(10.0, unit="N", minimum=5, maximum=50, doc="How hard to press.")
    tolerance: float = param(2.0, unit="N", above=0, doc="Pressed when the force is this close.")
    hold: float = param(1.0, unit="s", minimum=0, doc="How long to press.")
    patience: float = param(4.0, unit="s", above=0, doc="Fails when it has not pressed as it should for this long.")

    pressed: float = result(unit="N", doc="How hard the palm presses.")
    x: float = result(unit="m", doc="Where the palm's middle is as it presses, in the world.")
    y: float = result(unit="m", doc="Where the palm's middle is as it presses, in the world.")
    z: float = result(unit="m", doc="Where the palm's middle is as it presses, above the floor.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return one hand."""
        return of_hand(cls.resources, values["hand"])

    def initialise(self) -> None:
        """Begin before the way."""
        self._begin: np.ndarray | None = None
        self._way = np.zeros(3)
        self._since = self._until = self.robot.clock.now()
        self._there = self._touches = False
        self._touched = Lasting(_TOUCHES)
        self._held = Lasting(self.hold)

    def update(self) -> Status:
        """Bring the palm to the beginning of its way, move it on, and press."""
        state, hand = self.robot.state, self.hand
        if why := self.robot.touched(hand) if hand in state.hands else f"the robot has no {hand} hand":
            return self.fail(why)
        if self._begin is None:
            if not state.base_settled:
                return self.await_rest("waiting for a steady base")
            self._plan()
        now, palm = self.robot.clock.now(), state.hands[hand]
        return self._go_on(palm, now) if self._there else self._go_there(palm, now)

    def _plan(self) -> None:
        """Choose the way, shape (3,) each, world frame."""
        state, reach = self.robot.state, self.robot.config.reach_distance
        x, y, heading = state.stance
        cos, sin = math.cos(heading), math.sin(heading)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        height = 0.75 * float(state.gaze_position[2]) if self.height is None else self.height
        side = 1 if self.hand == "left" else -1
        self._begin = turn @ [_BEGINS * reach, side * _ASIDE * reach, height] + [x, y, 0.0]
        self._way = turn @ _WAYS[self.direction]
        self._since = self.robot.clock.now()

    def _go_there(self, palm: np.ndarray, now: float) -> Status:
        self.robot.move_hand(self.hand, self._begin)
        away = float(np.linalg.norm(palm - self._begin))
        if away < _NEAR:
            self._there, self._since, self._begin = True, now, palm
        elif now - self._since > self.patience:
            return self.fail(self.robot.why_no_nearer(self.hand, away))
        return self.running(f"{self.hand} hand {away * 100:.0f} cm away")

    def _go_on(self, palm: np.ndarray, now: float) -> Status:
        hand = self.hand
        self.robot.move_hand(hand, self._begin + self._way * (self.distance + _BEYOND), press=self.force)
        contact = self.robot.state.contacts.get(f"{hand}_arm")
        pressed = -float(contact.force @ self._way) if contact else 0.0
        if self._touches or self._touched.update(pressed >= self.force / 2, now):
            return self._press(palm, pressed, now)
        left = self.distance - float((palm - self._begin) @ self._way)
        if left <= 0 and pressed < self.force / 2:
            return self.fail(f"nothing to touch within {self.distance * 100:g} cm")
        if now - self._since > self.patience + self.distance / _SPEED:
            return self.fail(self.robot.why_no_nearer(hand, left))
        return self.running(f"moving the {hand} hand {_words(self.direction)}")

    def _press(self, palm: np.ndarray, pressed: float, now: float) -> Status:
        if not self._touches:
            self._touches, self._since, self._until = True, now, now + 2 * (self.hold + self.patience)
        self.pressed = pressed
        self.x, self.y, self.z = palm.tolist()
        right = abs(pressed - self.force) <= self.tolerance
        if self._held.update(right, now):
            return self.succeed(f"pressed with {pressed:.0f} N for {self.hold:g} s")
        if self.robot.state.gait is Gait.STEP:
            return self.fail(f"the robot has to step: it cannot press with {self.force:.0f} N there")
        if right:
            self._since = now
        elif now - self._since > self.patience or now > self._until:
            return self.fail(f"the {self.hand} hand presses with {pressed:.0f} N instead of {self.force:.0f} N")
        return self.running(f"pressing with {pressed:.0f} N")


def _words(direction: str) -> str:
    return direction if direction in ("ahead", "up", "down") else f"to the {direction}"
