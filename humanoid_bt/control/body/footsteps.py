"""Where to step: footholds from the stance foot toward a goal, a few ahead, replanned at every step."""

from __future__ import annotations

import math
from dataclasses import replace

from humanoid_bt.control.body.body import Footstep
from humanoid_bt.control.body.planar import ahead, seen_from, wrap
from humanoid_bt.core.messages import Array, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig

OTHER: dict[Side, Side] = {"left": "right", "right": "left"}
SIGN: dict[Side, float] = {"left": 1.0, "right": -1.0}

STEPS_AHEAD = 4

_TOE_IN = 0.5  # of the turn of a step outward that one inward may have
_TURN_SHARE = 0.5  # of its length that a step gives to the largest turn
_CLEARANCE = 0.01  # m between the soles
_GRIPS = 0.1  # rad by which a foot that carries the robot may turn: on dry floors hardly ever
_SHORTER, _LONGER, _SHORTEST = 0.6, 0.05, 0.4  # times, plus, and least share of the longest step
_TURN_COST = 0.7  # of the steps that a turn takes: it is mostly made on the way


class FootstepPlanner:
    """Plans footholds. A *stance* is the pose of the middle between the feet, shape (3,), world frame.

    Args:
        gait, sole: the robot's numbers.

    Attributes:
        stride: how long steps may be, as a share of the longest.
    """

    def __init__(self, gait: GaitConfig, sole: SoleConfig) -> None:
        self._longest, self._sole = gait, sole
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
        """Return the foot that steps first: the one on the inside of the turn, or on the side of the goal."""
        turn = wrap(self._heading(stance, goal) - stance[2])
        if abs(turn) < self._gait.arrived_angle:
            turn = seen_from(stance, goal)[1]
        return "left" if turn > 0 else "right"

    def next_stance(self, stance: Array, goal: Array, swing: Side) -> Array:
        """Return the stance one step nearer to the goal: it turns on its way, and goes sideways or back if it is short.

        Args:
            stance: that of the foot that stays.
            goal: where to stand.
            swing: the foot that makes the step.
        """
        gait, outward = self._gait, SIGN[swing]
        x, y = seen_from(stance, goal)
        turn = wrap(self._heading(stance, goal) - stance[2])
        turn = outward * min(max(outward * turn, -_TOE_IN * gait.step_turn), gait.step_turn)
        left = 1 - _TURN_SHARE * abs(turn) / gait.step_turn  # of the step's length
        along = min(max(x, -gait.step_back * left), gait.step_forward * left)
        aside = min(max(outward * y, -self._room(turn)), gait.step_sideways * left)
        if aside > 0:
            most = left * (gait.step_forward if along > 0 else gait.step_back), left * gait.step_sideways
            longer = max(1.0, math.hypot(along / most[0], aside / most[1]))
            along, aside = along / longer, aside / longer
        return ahead(stance, along, outward * aside, turn)

    def _room(self, turn: float) -> float:
        """Return how far a foot that is turned may come nearer to the other one than it stands beside it [m]."""
        gait, sole = self._gait, self._sole
        apart = 0.5 * gait.stance_width * (1 + math.cos(turn))
        wide = sole.half_width * (1 + math.cos(turn)) + sole.half_length * abs(math.sin(turn)) + _CLEARANCE
        return max(0.0, min(apart - max(gait.separation_min, wide), gait.step_sideways))

    def _heading(self, stance: Array, goal: Array) -> float:
        """Return where to face on the way: the fewer steps it takes to turn there, walk, and turn to the end."""
        gait = self._gait
        x, y = goal[:2] - stance[:2]
        way, bearing = math.hypot(x, y), math.atan2(y, x)
        start, end = float(stance[2]), float(goal[2])
        if way < gait.arrived_distance:
            return end
        turning = _TURN_COST / (0.5 * (1 + _TOE_IN) * gait.step_turn)
        sideways = 0.5 * (gait.step_sideways + self._room(0.0))

        def steps(heading: float) -> float:
            along, across = way * math.cos(bearing - heading), way * math.sin(bearing - heading)
            straight = math.hypot(along / (gait.step_forward if along > 0 else gait.step_back), across / sideways)
            return straight + turning * (abs(wrap(heading - start)) + abs(wrap(end - heading)))

        to_way, to_end, at_end = wrap(bearing - start), wrap(end - start), wrap(end - bearing)
        between = start + 0.5 * to_end, start + 0.5 * to_way, bearing + 0.5 * at_end
        return min((end, start, bearing, bearing + math.pi, *between), key=steps)

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
            after = stance if goal is None else self.next_stance(stance, goal, swing)
            support = self.foothold(swing, after)
            steps.append(Footstep(swing, support))
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
