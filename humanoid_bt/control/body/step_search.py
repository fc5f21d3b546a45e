"""The fewest steps to a place: every heading on the way is tried, and what the steps then reach.

A walk turns to some heading as soon as it can, keeps it, and turns to its end as late as it can; all the while each
step goes as far toward the goal as its turn leaves it. For a number of steps that makes one walk of every heading.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from humanoid_bt.core.compiled import compiled, inlined
from humanoid_bt.core.messages import Array

MOST_STEPS = 64
"""That a plan has room for."""

TOE_IN = 0.5
"""Of the turn of a step outward, what one inward may have."""

TURN_SHARE = 0.5
"""Of its length, what a step gives to the largest turn."""

_CLEARANCE = 0.01  # m between the soles
_HEADINGS = 16  # that are tried, all around, besides those that the goal says
_THERE, _TURNED = 0.008, 0.012  # m and rad from the goal, of a plan that leads there
_EASED = 0.7, 0.85, 1.0  # shares of its reach with which a robot may make as few steps, the first that does
_FAILED = 1e9


class Reach(NamedTuple):
    """What a step can do.

    Attributes:
        forward, back, aside: how long it is at most [m].
        turn: the most outward [rad].
        width: between the feet of a robot that stands [m].
        apart: the least between their middle lines [m].
        half_length, half_width: of a sole [m].
    """

    forward: float
    back: float
    aside: float
    turn: float
    width: float
    apart: float
    half_length: float
    half_width: float


@inlined
def _room(reach: Reach, turn: float) -> float:
    """Return how far a foot that is turned may come nearer to the other one than it stands beside it [m]."""
    apart = 0.5 * reach.width * (1 + math.cos(turn))
    wide = reach.half_width * (1 + math.cos(turn)) + reach.half_length * abs(math.sin(turn)) + _CLEARANCE
    return max(0.0, min(apart - max(reach.apart, wide), reach.aside))


@inlined
def _walk(
    reach: Reach, steps: int, outward: float, stance: Array, goal: Array, end: float, heading: float, made: Array
) -> float:
    """Make a number of steps; return what they cost: _FAILED, and by how much, if they do not lead to the goal.

    Args:
        reach: of a step.
        steps: how many.
        outward: 1 if the left foot makes the first step, else -1.
        stance: where the walk begins, shape (3,).
        goal: where it is to end, shape (3,).
        end: heading there, counted on from that of ``stance`` [rad].
        heading: on the way, counted so, too [rad].
        made: the stances are written here, shape (MOST_STEPS, 3).
    """
    x, y, faces = stance[0], stance[1], stance[2]
    cost = 0.0
    for k in range(steps):
        rest = steps - 1 - k
        left, right = (reach.turn, TOE_IN * reach.turn) if outward > 0 else (TOE_IN * reach.turn, reach.turn)
        others, own = (rest + 1) // 2, rest // 2  # steps that follow, with the other foot and with this one
        least, most = end - own * left - others * right, end + own * right + others * left
        turn = min(max(min(max(heading, least), most) - faces, -right), left)
        cos, sin = math.cos(faces), math.sin(faces)
        along = cos * (goal[0] - x) + sin * (goal[1] - y)
        aside = outward * (cos * (goal[1] - y) - sin * (goal[0] - x))
        share = 1 - TURN_SHARE * abs(turn) / reach.turn  # of the step's length
        longest = share * (reach.forward if along > 0 else reach.back)
        widest = share * reach.aside
        along = min(max(along, -longest), longest)
        aside = min(max(aside, -_room(reach, turn)), widest)
        if aside > 0:
            longer = max(1.0, math.hypot(along / longest, aside / widest))
            along, aside = along / longer, aside / longer
        cost += (turn / (left if turn > 0 else right)) ** 2 + (along / longest) ** 2 + (aside / widest) ** 2
        aside *= outward
        x, y, faces = x + cos * along - sin * aside, y + sin * along + cos * aside, faces + turn
        made[k, 0], made[k, 1], made[k, 2] = x, y, faces
        outward = -outward
    off = math.hypot(goal[0] - x, goal[1] - y)
    missed = abs(end - faces)
    return cost if off < _THERE and missed < _TURNED else _FAILED + off + missed


@inlined
def _best(
    numbers: tuple[float, ...],
    share: float,
    steps: int,
    outward: float,
    stance: Array,
    goal: Array,
    found: Array,
    tried: Array,
) -> float:
    """Find the walk of a number of steps that costs least; arguments as those of :func:`fewest_steps`.

    Args:
        share: of what a step can do.
        steps: how many.
    """
    forward, back, aside, turn, width, apart, half_length, half_width = numbers
    reach = Reach(share * forward, share * back, share * aside, share * turn, width, apart, half_length, half_width)
    faces, least = stance[2], math.inf
    about = (goal[2] - faces + math.pi) % (2 * math.pi) - math.pi
    bearing = (math.atan2(goal[1] - stance[1], goal[0] - stance[0]) - faces + math.pi) % (2 * math.pi) - math.pi
    for end in (about, about - math.copysign(2 * math.pi, about)):
        for number in range(_HEADINGS + 3):
            heading = (number - _HEADINGS // 2) * 2 * math.pi / _HEADINGS
            if number == _HEADINGS:
                heading = end
            elif number == _HEADINGS + 1:
                heading = bearing
            elif number == _HEADINGS + 2:
                heading = bearing - math.copysign(math.pi, bearing)
            cost = _walk(reach, steps, outward, stance, goal, faces + end, faces + heading, tried)
            if cost < least:
                least = cost
                found[:steps] = tried[:steps]
    return least


@compiled("UniTuple(f8, 2)(UniTuple(f8, 8), f8, f8[::1], f8[::1], f8[:, ::1], f8[:, ::1])")
def fewest_steps(
    numbers: tuple[float, ...], outward: float, stance: Array, goal: Array, found: Array, tried: Array
) -> tuple[float, float]:
    """Find the walk of the fewest steps to a goal, and of those the one that costs least.

    Args:
        numbers: a :class:`Reach`.
        outward: 1 if the left foot makes the first step, else -1.
        stance: where the walk begins: that of the foot that stays, shape (3,).
        goal: where it is to end, shape (3,).
        found: its stances are written here, shape (MOST_STEPS, 3).
        tried: room for others, shape (MOST_STEPS, 3).

    Returns:
        How many steps it has, and what they cost. One that has no room left leads nearer.
    """
    way = math.hypot(goal[0] - stance[0], goal[1] - stance[1])
    steps = min(max(int(way / max(numbers[0], numbers[1], numbers[2])), 1), MOST_STEPS)
    while _best(numbers, 1.0, steps, outward, stance, goal, found, tried) >= _FAILED and steps < MOST_STEPS:
        steps += 1
    cost = _FAILED
    for share in _EASED:
        cost = _best(numbers, share, steps, outward, stance, goal, found, tried)
        if cost < _FAILED:
            break
    return float(steps), cost
