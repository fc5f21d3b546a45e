"""Where to step: footholds from the stance foot toward a goal, a few ahead, replanned at every step."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from humanoid_bt.control.body.planar import ahead, seen_from, wrap
from humanoid_bt.core.messages import Array, Side
from humanoid_bt.robot.config import GaitConfig

OTHER: dict[Side, Side] = {"left": "right", "right": "left"}
SIGN: dict[Side, float] = {"left": 1.0, "right": -1.0}

STEPS_AHEAD = 4


@dataclass(frozen=True)
class Footstep:
    """A foothold: which foot, and its pose (x, y, yaw), world frame."""

    side: Side
    pose: Array


class FootstepPlanner:
    """Plans footholds. A *stance* is the pose of the middle between the feet, shape (3,), world frame.

    Args:
        gait: the robot's gait.
    """

    def __init__(self, gait: GaitConfig) -> None:
        self._gait = gait

    def stance_beside(self, side: Side, foot: Array) -> Array:
        """Return the stance that belongs to a foot on the ground."""
        return ahead(foot, 0.0, -SIGN[side] * self._gait.stance_width / 2)

    def foothold(self, side: Side, stance: Array) -> Array:
        """Return where a foot stands in a stance."""
        return ahead(stance, 0.0, SIGN[side] * self._gait.stance_width / 2)

    def arrived(self, stance: Array, goal: Array) -> bool:
        """Return whether no further step is worth making."""
        gait = self._gait
        return _within(stance, goal, gait.arrived_distance, gait.arrived_angle)

    def must_walk(self, stance: Array, goal: Array) -> bool:
        """Return whether a standing robot has to start: farther than it stops, or it would march in place."""
        gait = self._gait
        return not _within(stance, goal, gait.leave_distance, gait.leave_angle)

    def first_swing(self, stance: Array, goal: Array) -> Side:
        """Return the foot that steps first: the one on the inside of the turn."""
        x, y = seen_from(stance, goal)
        turn = math.atan2(y, x) if math.hypot(x, y) > self._gait.near else wrap(goal[2] - stance[2])
        return "left" if turn > 0 else "right"

    def next_stance(self, stance: Array, goal: Array) -> Array:
        """Return the stance one step nearer to the goal.

        Far away it turns toward the goal and then walks forward; near, it side-steps and turns to the goal's heading.
        """
        gait = self._gait
        x, y = seen_from(stance, goal)
        forward, sideways = 0.0, 0.0
        if math.hypot(x, y) > gait.near:
            bearing = math.atan2(y, x)
            turn = bearing
            if abs(bearing) <= gait.facing:
                forward = x
        else:
            turn = wrap(goal[2] - stance[2])
            forward, sideways = x, y
        return ahead(
            stance,
            float(np.clip(forward, -gait.step_back, gait.step_forward)),
            float(np.clip(sideways, -gait.step_sideways, gait.step_sideways)),
            float(np.clip(turn, -gait.step_turn, gait.step_turn)),
        )

    def plan(self, swing: Side, support: Array, goal: Array | None) -> tuple[list[Footstep], bool]:
        """Plan the next footholds.

        Args:
            swing: the foot that steps next.
            support: pose of the other foot, which stays.
            goal: where to stand; None to bring the feet together and stop.

        Returns:
            At least one foothold, and whether the last of them ends the walk.
        """
        steps: list[Footstep] = []
        done = False
        while len(steps) < STEPS_AHEAD and not done:
            stance = self.stance_beside(OTHER[swing], support)
            done = goal is None or self.arrived(stance, goal)
            after = stance if goal is None else self.next_stance(stance, goal)
            support = self.foothold(swing, after)
            steps.append(Footstep(swing, support))
            swing = OTHER[swing]
        return steps, done


def _within(stance: Array, goal: Array, distance: float, angle: float) -> bool:
    offset = goal[:2] - stance[:2]
    return math.hypot(*offset) < distance and bool(abs(wrap(goal[2] - stance[2])) < angle)
