"""Where to step: footholds from the stance foot toward a goal, a few ahead, replanned at every step."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from humanoid_bt.control.body.body import Footstep
from humanoid_bt.control.body.planar import ahead, wrap
from humanoid_bt.control.body.step_search import MOST_STEPS, Reach, fewest_steps
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig

OTHER: dict[Side, Side] = {"left": "right", "right": "left"}
SIGN: dict[Side, float] = {"left": 1.0, "right": -1.0}

STEPS_AHEAD = 4

_FAR = 2.0  # m of the way that are planned, if steps are not shorter than they may be
_GRIPS = 0.1  # rad by which a foot that carries the robot may turn: on dry floors hardly ever
_SHORTER, _LONGER, _SHORTEST = 0.6, 0.05, 0.4  # times, plus, and least share of the longest step


class FootstepPlanner:
    """Plans footholds. A *stance* is the pose of the middle between the feet, shape (3,), world frame.

    Args:
        gait, sole: the robot's numbers.

    Attributes:
        stride: how long steps may be, as a share of the longest.
    """

    def __init__(self, gait: GaitConfig, sole: SoleConfig) -> None:
        self._longest, self._sole = gait, sole
        self._found, self._tried = np.empty((2, MOST_STEPS, 3))
        self.reset()

    def reset(self) -> None:
        """Begin on a floor on which feet do not slip."""
        self._gait, self.stride = self._longest, 1.0

    def stood(self, turned: float) -> None:
        """Make shorter steps where feet slip, and longer ones again, little by little, where they do not.

        Args:
            turned: by how much the foot that carried the robot has turned on the ground in a step [rad].
        """
        stride = self.stride * _SHORTER if abs(turned) > _GRIPS else self.stride + _LONGER
        stride = min(max(stride, _SHORTEST), 1.0)
        if stride != self.stride:
            self.stride, gait = stride, self._longest
            self._gait = replace(
                gait,
                step_forward=stride * gait.step_forward,
                step_back=stride * gait.step_back,
                step_sideways=stride * gait.step_sideways,
                step_turn=stride * gait.step_turn,
            )

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
        """Return the foot that steps first: that of the shorter walk, the right one if it is the same."""
        return min(reversed(SIDES), key=lambda swing: self._search(swing, stance, goal))

    def _search(self, swing: Side, stance: Array, goal: Array) -> tuple[float, float]:
        """Write into ``_found`` the stances of the shortest walk; return how many steps it has, and what they cost."""
        x, y = (goal - stance)[:2].tolist()
        far = math.hypot(x, y) / (_FAR * self.stride)
        if far > 1:
            goal = np.array([stance.item(0) + x / far, stance.item(1) + y / far, math.atan2(y, x)])
        gait, sole = self._gait, self._sole
        reach = Reach(
            gait.step_forward,
            gait.step_back,
            gait.step_sideways,
            gait.step_turn,
            gait.stance_width,
            gait.separation_min,
            sole.half_length,
            sole.half_width,
        )
        return fewest_steps(tuple(reach), SIGN[swing], stance, goal, self._found, self._tried)

    def plan(self, swing: Side, support: Array, goal: Array | None) -> tuple[list[Footstep], bool]:
        """Plan the next footholds.

        Args:
            swing: the foot that steps next.
            support: pose of the other foot, which stays.
            goal: where to stand; None to bring the feet together and stop.

        Returns:
            At least one foothold, and whether the last of them ends the walk.
        """
        stance = self.stance_beside(OTHER[swing], support)
        if goal is None or self.arrived(stance, goal):
            return [Footstep(swing, self.foothold(swing, stance))], True
        count, _ = self._search(swing, stance, goal)
        stances = list(self._found[: min(int(count), STEPS_AHEAD)])
        done = len(stances) < STEPS_AHEAD
        steps = []
        for each in stances + stances[-1:] * done:
            steps.append(Footstep(swing, self.foothold(swing, each)))
            swing = OTHER[swing]
        return steps, done

    def in_place(self, swing: Side, support: Array) -> list[Footstep]:
        """Plan steps that bring the feet beside each other, and keep them there; see :meth:`plan`."""
        steps: list[Footstep] = []
        for _ in range(STEPS_AHEAD):
            support = self.foothold(swing, self.stance_beside(OTHER[swing], support))
            steps.append(Footstep(swing, support))
            swing = OTHER[swing]
        return steps


def _within(stance: Array, goal: Array, distance: float, angle: float) -> bool:
    offset = goal[:2] - stance[:2]
    return math.hypot(*offset) < distance and bool(abs(wrap(goal[2] - stance[2])) < angle)
