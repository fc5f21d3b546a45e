"""The shortest way between obstacles: A* on the corners at which such a way turns (a visibility graph).

Only obstacles that stand in a way are looked at: the way is planned without any, then once more with those that it goes
through, until it is free. A way round some of them that is free of all is the shortest way round all.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.messages import Array
from humanoid_bt.decision.obstacles import SLACK, Obstacles, clear

_TINY = 1e-9


@dataclass(frozen=True)
class Plan:
    """A way, or what stands in it.

    Attributes:
        points: from the start to a goal, shape (k, 2), world frame [m]; None if there is no way.
        goal: number of that goal.
        blocking: the obstacles of which some stand in every way, by number; none if there is a way.
    """

    points: Array | None
    goal: int = 0
    blocking: Sequence[int] = ()


def plan(obstacles: Obstacles, start: Array, goals: Array, room: float, costs: Array | None = None) -> Plan:
    """Return the shortest way to one of some goals that keeps a distance from all obstacles.

    A way may begin and end nearer than that to an obstacle, and there comes no nearer.

    Args:
        obstacles: all there are; those around the start itself are left alone.
        start: shape (2,), world frame [m].
        goals: shape (g, 2), world frame [m], none of them in an obstacle.
        room: that distance [m].
        costs: what ending at a goal is worth, as metres of way: shape (g,).
    """
    task = _Task(start, goals, np.zeros(len(goals)) if costs is None else costs, room)
    beside = obstacles.distances(np.concatenate([start[None], goals]))
    allowed = np.minimum(room, beside - SLACK)  # at the start and at each goal
    regarded: list[int] = []
    while True:
        points, goal = _search(obstacles.some(regarded), task, allowed[:, regarded])
        if points is None:
            return Plan(None, blocking=regarded)
        limits = np.full((len(points) - 1, len(obstacles)), room)
        limits[0] = allowed[0]
        limits[-1] = np.minimum(limits[-1], allowed[1 + goal])
        beyond = obstacles.beyond(points)
        free = clear(beyond[:-1], beyond[1:], limits).all(axis=0)
        met = [i for i in np.flatnonzero(~free).tolist() if i not in regarded]
        if not met:
            return Plan(points, goal)
        regarded.extend(met)


class _Task(NamedTuple):
    """Where a way begins, where it may end, and how far from obstacles it stays: as :func:`plan` is asked."""

    start: Array
    goals: Array
    costs: Array
    room: float


def _search(obstacles: Obstacles, task: _Task, allowed: Array) -> tuple[Array | None, int]:
    """Return the shortest way and the number of its goal; None without one.

    Args:
        obstacles: n of them.
        task: what is asked.
        allowed: how near a way may come to each at the start and at each goal, shape (1 + g, n) [m].
    """
    start, goals, costs, room = task
    count = len(goals)
    nodes, sides = _nodes(obstacles, start, goals, room)
    beyond = obstacles.beyond(nodes)
    limits = np.full((len(nodes), len(obstacles)), room)
    limits[: 1 + count] = allowed
    estimate = (np.linalg.norm(nodes[:, None] - goals, axis=2) + costs).min(axis=1)
    estimate[1 : 1 + count] = costs
    distances, usable = _ways(nodes, sides)
    length, before = np.full(len(nodes), np.inf), np.zeros(len(nodes), dtype=int)
    length[0] = 0.0
    done = np.zeros(len(nodes), dtype=bool)
    queue = [(float(estimate[0]), 0)]
    while queue:
        _, node = heapq.heappop(queue)
        if 1 <= node <= count:
            return nodes[_back(before, node)], node - 1
        if done[node]:
            continue
        done[node] = True
        ways = length[node] + distances[node]
        nearer = np.flatnonzero(usable[node] & (ways < length - 1e-12))
        if len(obstacles) and len(nearer):
            free = clear(beyond[node], beyond[nearer], np.minimum(limits[node], limits[nearer]))
            nearer = nearer[free.all(axis=1)]
        for other in nearer.tolist():
            length[other], before[other] = ways[other], node
            heapq.heappush(queue, (float(ways[other] + estimate[other]), other))
    return None, 0


def _nodes(obstacles: Obstacles, start: Array, goals: Array, room: float) -> tuple[Array, Array]:
    """Return the start, the goals and the corners that are free, shape (m, 2), and the ways to both neighbours of each.

    Those of a corner, shape (m, 2, 2), run along the sides that meet there; start and goals have none, which is 0.
    """
    around = obstacles.corners(room)
    sides = np.stack([np.roll(around, 1, axis=1), np.roll(around, -1, axis=1)], 2) - around[:, :, None]
    corners, sides = around.reshape(-1, 2), sides.reshape(-1, 2, 2)
    if len(corners):
        free = (obstacles.distances(corners) >= room).all(axis=1)
        corners, sides = corners[free], sides[free]
    ends = np.concatenate([start[None], goals])
    return np.concatenate([ends, corners]), np.concatenate([np.zeros((len(ends), 2, 2)), sides])


def _ways(nodes: Array, sides: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return how far all nodes are from each other, and which straight ways may be part of a shortest way: (m, m) each.

    A way may be when it touches the corners at both of its ends: what a corner belongs to is on one side of it.
    """
    ways = nodes[None] - nodes[:, None]
    crossed = ways[..., :1] * sides[None, :, :, 1] - ways[..., 1:] * sides[None, :, :, 0]
    # ends may lie nearer to a corner's obstacle than the corner does
    ends: NDArray[np.bool_] = np.logical_not(sides.any(axis=(1, 2)))
    touches = crossed[..., 0] * crossed[..., 1] >= -_TINY
    usable = ends | ends[:, None] | (touches & touches.T)
    return np.hypot(ways[..., 0], ways[..., 1]), np.asarray(usable)


def _back(before: Array, node: int) -> list[int]:
    """Return the nodes from the start to a node."""
    way = [node]
    while way[-1] != 0:
        way.append(int(before[way[-1]]))
    return way[::-1]
