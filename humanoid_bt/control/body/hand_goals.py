"""Where inverse kinematics shall bring commanded palms: references, pressing, one hand that leads the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Protocol

from humanoid_bt.control.body.palm_reference import PalmReference
from humanoid_bt.control.body.press import Press
from humanoid_bt.control.body.yielding import Felt, YieldingArms
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.messages import SIDES, Array, HandTarget, Side, Target
from humanoid_bt.core.palm import in_world, other_side
from humanoid_bt.robot.model import RobotModel


class PlannedPalms(Protocol):
    """A planned motion, as far as palms go."""

    def palm(self, side: Side) -> Array:
        """Return the place of a palm, world frame, shape (3,)."""

    def palm_frame(self, side: Side) -> Array:
        """Return how it is turned: the rotation matrix of its frame, shape (3, 3)."""


class HandGoals:
    """The references of all palms.

    Args:
        robot: the robot.
        dynamics: as it is estimated.
        planned: its planned motion.
        contact: what touches it.
        arms: those that yield.
        dt: control period [s].
    """

    def __init__(
        self,
        robot: RobotModel,
        dynamics: RobotDynamics,
        planned: PlannedPalms,
        *,
        contact: Felt,
        arms: YieldingArms,
        dt: float,
    ) -> None:
        self._weights, self._dt = robot.config.whole_body, dt
        self._sides: list[Side] = [side for side in SIDES if side in robot.config.hands]
        self._dynamics, self._planned, self._contact, self._arms = dynamics, planned, contact, arms
        self.reset()

    def reset(self) -> None:
        """Let all hands go."""
        self._hands = {side: PalmReference(self._weights, self._dt) for side in self._sides}
        self._presses = {side: Press(self._dt) for side in self._sides}

    def update(
        self, targets: Mapping[str, Target], hold: bool, stance: Array, walks: bool
    ) -> tuple[dict[Side, Array], dict[Side, HandTarget]]:
        """Return the places of the hands that are commanded, and the goals of those that are more than a place.

        Args:
            targets: resource -> target.
            hold: keep hands where they are, as seen from the stance.
            stance: pose of the middle between the feet, world frame, shape (3,).
            walks: whether the stance moves.
        """
        positions: dict[Side, Array] = {}
        palms: dict[Side, HandTarget] = {}
        followers: dict[Side, HandTarget | None] = {}
        for side, reference in self._hands.items():
            if side in self._arms.sides:
                reference.release()
                self._presses[side].reset()
                continue
            target = targets.get(f"{side}_hand") or (None if hold else self._arms.away(side))
            hand = target if isinstance(target, HandTarget) else None
            if hand is None and reference.free:
                continue
            hand = self._pressing(side, hand, hold)
            if reference.relative if hold else hand is not None and hand.relative:
                followers[side] = hand
                continue
            found = reference.update(
                hand,
                hold,
                self._dynamics.palm(side),
                self._planned.palm(side),
                stance=stance,
                walks=walks,
                frames=partial(self._palm_frames, side),
            )
            if found is not None:
                positions[side], goal = found
                if goal is not None:
                    palms[side] = goal
        for side, hand in followers.items():
            self._follow(side, hand, hold, positions, palms)
        return positions, palms

    def _pressing(self, side: Side, hand: HandTarget | None, hold: bool) -> HandTarget | None:
        """Return where a palm is to go: one that presses only as far as its force asks for."""
        press = self._presses[side]
        if hand is None or hold or hand.relative or not hand.press:
            press.reset()
            return hand
        force = self._contact.forces[f"{side}_arm"]
        return replace(hand, position=press.aim(hand.position, hand.press, self._planned.palm(side), force))

    def _palm_frames(self, side: Side) -> tuple[Array, Array]:
        return self._dynamics.palm_frame(side), self._planned.palm_frame(side)

    def _follow(
        self,
        side: Side,
        target: HandTarget | None,
        hold: bool,
        positions: dict[Side, Array],
        palms: dict[Side, HandTarget],
    ) -> None:
        """Hold a palm relative to the other one; where that one is free, let it go, too."""
        leader = other_side(side)
        if leader not in positions:
            self._hands[side].release()
            return
        bodies: tuple[PlannedPalms, PlannedPalms] = (self._dynamics, self._planned)
        measured, planned = ((body.palm(side), body.palm_frame(side)) for body in bodies)
        led, leads = ((body.palm(leader), body.palm_frame(leader)) for body in bodies)
        goal = self._hands[side].follow(target, hold, measured, planned, (led, leads))
        if goal is not None:
            palms[side] = goal
            positions[side] = in_world(goal, *leads).position
