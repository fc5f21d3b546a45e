"""The eye of the 3D view: it turns with the robot, and has in the picture what the robot sees and goes for."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import rerun as rr

from humanoid_bt.core.messages import SIDES, Array, BaseTarget, State
from humanoid_bt.core.palm import commanded
from humanoid_bt.perception.track import Track
from humanoid_bt.record.batch import Batch
from humanoid_bt.record.columns import send, xyzw
from humanoid_bt.record.scene_view import WORLD

FRAME = "eye"
"""Frame that the eye is fixed in, at :func:`position`, looking at the origin; also the entity that carries its pose."""

_SIDE = math.radians(-62)  # where the eye is, seen from the robot: right of ahead, where both hands are seen
_ABOVE = math.radians(11)  # the eye looks down by this
_DISTANCE = 3.6  # of the eye from the origin of its frame, which people orbit [base heights]
_NEAREST = 2.7  # of the eye from the middle of the picture [base heights]
_HEAD = 2.1  # top of the robot with some air [base heights]
_WIDTH, _HEIGHT = 0.72, 0.44  # tangents of half the angles used of the picture: it is 55 degrees high, and wider
_FARTHEST = 3.0  # m; what is farther away from the robot is only partly on the way to it
_SAME = 0.5  # m; a percept this near an object is one of it
_SETTLING = 0.6  # s; time constant of each of the two filters in a row that make the motion smooth

Point = tuple[float, float, float]  # a dozen of them take arrays five times as long


def position(base_height: float) -> tuple[float, float, float]:
    """Return where the eye is in its frame [m], for a robot whose base is at this height [m]."""
    x, y, z = _forward(0.0)
    back = -_DISTANCE * base_height
    return back * x, back * y, back * z


class Eye:
    """Follows one robot.

    Args:
        base_height: of the standing robot [m], the measure of the picture.
        heights: object name -> lowest and highest point of it, relative to its position [m].
    """

    def __init__(self, base_height: float, heights: Mapping[str, tuple[float, float]]) -> None:
        self._base_height, self._heights = base_height, heights
        self._time = 0.0
        self._filters: tuple[list[float], list[float]] | None = None  # each: heading, middle of the picture, distance
        self._rows: Batch[tuple[float, float, Point]] = Batch("the eye of the view")

    def add(
        self,
        state: State,
        tracks: Mapping[str, Track],
        objects: Mapping[str, Array],
        routes: Sequence[Array] = (),
    ) -> None:
        """Look at one state.

        Args:
            state: it.
            tracks: the percepts known with it.
            objects: positions of the scene's objects, world frame, shape (3,) [m].
            routes: ways that are followed, each of shape (n, 2), world frame [m].
        """
        points = [*self._points(state, tracks, objects), *_ahead(state, routes)]
        heading, x, y, z, distance = self._smoothed(state, points)
        right, forward, up = _forward(heading)
        back = distance - _DISTANCE * self._base_height
        self._rows.append((state.time, heading, (x - back * right, y - back * forward, z - back * up)))

    def flush(self, stream: Any) -> None:
        """Write where the eye was since the last flush."""
        self._rows.draw(partial(_draw, stream))

    def _points(self, state: State, tracks: Mapping[str, Track], objects: Mapping[str, Array]) -> list[Point]:
        """Return what has to be in the picture, world frame [m]."""
        x, y, _ = state.base_position.tolist()
        feet = (x, y, 0.0)
        points: list[Point] = [feet, (x, y, _HEAD * self._base_height)]
        for target in state.targets.values():
            if isinstance(target, BaseTarget):
                points.append(_near(feet, (*target.position.tolist(), 0.0)))
        for side in SIDES:
            if (hand := commanded(state, side)) is not None:
                points.append(_near(feet, hand.position.tolist()))
        places = [(name, place.tolist()) for name, place in objects.items()]
        for track in tracks.values():
            seen = track.position_world.tolist()
            points += [_near(feet, seen), _near(feet, (*seen[:2], 0.0))]
            for name, (across, along, height) in places:
                if math.dist((across, along, height), seen) < _SAME:
                    points += [_near(feet, (across, along, height + end)) for end in self._heights[name]]
        return points

    def _smoothed(self, state: State, points: Sequence[Point]) -> list[float]:
        """Return the eye's heading, the middle of its picture and how far it is from there, low-passed."""
        step, self._time = state.time - self._time, state.time
        heading = float(state.stance[2])
        if self._filters is None:
            first = [heading, *_framed(points, heading, self._base_height)]
            self._filters = first, first
        share = 1 - math.exp(-step / _SETTLING)
        near, far = self._filters
        turn = math.remainder(heading - near[0], math.tau)
        goal = (near[0] + turn, *_framed(points, far[0], self._base_height))
        near = [value + share * (aim - value) for value, aim in zip(near, goal, strict=True)]
        far = [value + share * (aim - value) for value, aim in zip(far, near, strict=True)]
        if math.isfinite(sum(far)):  # else the next state begins where this one did
            self._filters = near, far
        return far


def _draw(stream: Any, rows: Sequence[tuple[float, float, Point]]) -> None:
    times, headings, origins = zip(*rows, strict=True)
    half = np.array(headings) / 2
    turns = np.stack([np.cos(half), np.zeros_like(half), np.zeros_like(half), np.sin(half)], axis=-1)
    columns = rr.Transform3D.columns(
        translation=np.array(origins),
        quaternion=xyzw(turns),
        parent_frame=[WORLD] * len(times),
        child_frame=[FRAME] * len(times),
    )
    send(stream, FRAME, times, columns)


def _framed(points: Sequence[Point], heading: float, base_height: float) -> tuple[float, float, float, float]:
    """Return the middle of the picture that has all points in it (x, y, z), and the eye's distance from there [m]."""
    fx, fy, fz = _forward(heading)
    level = math.hypot(fx, fy)
    rx, ry = fy / level, -fx / level  # to the right
    ux, uy, uz = ry * fz, -rx * fz, level  # up
    asides = [rx * x + ry * y for x, y, _ in points]
    aboves = [ux * x + uy * y + uz * z for x, y, z in points]
    depths = [fx * x + fy * y + fz * z for x, y, z in points]
    depth, aside, above = depths[0], (min(asides) + max(asides)) / 2, (min(aboves) + max(aboves)) / 2
    wide = [
        max(abs(right - aside) / _WIDTH, abs(high - above) / _HEIGHT) - (deep - depth)
        for right, high, deep in zip(asides, aboves, depths, strict=True)
    ]
    x, y = depth * fx + aside * rx + above * ux, depth * fy + aside * ry + above * uy
    return x, y, depth * fz + above * uz, max(*wide, _NEAREST * base_height)


def _forward(heading: float) -> tuple[float, float, float]:
    """Return the direction in which the eye looks, beside a robot of this heading."""
    side, level = heading + _SIDE, math.cos(_ABOVE)
    return -level * math.cos(side), -level * math.sin(side), -math.sin(_ABOVE)


def _ahead(state: State, routes: Sequence[Array]) -> list[Point]:
    """Return the points of ways that are still ahead of the robot, world frame [m]."""
    here = state.base_position[:2]
    begins = [int(np.linalg.norm(route - here, axis=1).argmin()) for route in routes]
    left = [point for route, begin in zip(routes, begins, strict=True) for point in route[begin:].tolist()]
    return [_near((*here.tolist(), 0.0), (x, y, 0.0)) for x, y in left]


def _near(start: Point, point: Point) -> Point:
    """Return the point, or the one on the way to it that is not too far."""
    distance = math.dist(start, point)
    if distance <= _FARTHEST:
        return point
    share = _FARTHEST / distance
    x, y, z = (begin + (end - begin) * share for begin, end in zip(start, point, strict=True))
    return x, y, z
