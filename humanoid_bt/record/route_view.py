"""What the robot takes for obstacles, and the way it takes round them, drawn into the 3D view."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import rerun as rr

from humanoid_bt.core.messages import Array, State
from humanoid_bt.perception.track import Track
from humanoid_bt.record.batch import Batch
from humanoid_bt.record.columns import send_sets
from humanoid_bt.record.scene_view import WORLD

OBSTACLES = f"{WORLD}/obstacles"
"""Entity of the boxes around solid things, where the robot believes them to be."""

ROUTE = f"{WORLD}/route"
"""Entity of the way that the base is to take."""

_LIFT = 0.006  # m above the floor
_OBSTACLE_COLOR = (255, 107, 107)
_ROUTE_COLOR = (252, 196, 25)


class RouteView:
    """Obstacles and ways of one robot.

    Attributes:
        latest: the ways that are followed now, each of shape (n, 2), world frame [m].
    """

    def __init__(self) -> None:
        self._seen: Batch[tuple[float, Sequence[Track]]] = Batch("obstacles")
        self._boxes: list[tuple[float, ...]] = []  # as they were last
        self._routes: Batch[tuple[float, Sequence[Array]]] = Batch("the way round obstacles")
        self.latest: Sequence[Array] = ()

    def log_static(self, stream: Any) -> None:
        """Write what never changes: frames, colours."""
        frame = rr.CoordinateFrame(WORLD)
        boxes = rr.Boxes3D.from_fields(colors=[_OBSTACLE_COLOR], radii=[0.003])
        stream.log(OBSTACLES, frame, boxes, static=True)
        stream.log(ROUTE, frame, rr.LineStrips3D.from_fields(colors=[_ROUTE_COLOR], radii=[0.01]), static=True)

    def add(self, state: State, tracks: Mapping[str, Track]) -> None:
        """Take the percepts as they are known with a state."""
        solid = [track for track in tracks.values() if track.size is not None and not track.gone]
        boxes = [(*track.position_world.tolist(), track.heading_world) for track in solid]
        if boxes != self._boxes:
            self._boxes = boxes
            self._seen.append((state.time, solid))

    def add_routes(self, time: float, routes: Sequence[Array]) -> None:
        """Take the ways that are followed from a time [s] on, each of shape (n, 2), world frame [m]."""
        self._routes.append((time, routes))
        self.latest = routes

    def flush(self, stream: Any) -> None:
        """Write what was added since the last flush."""
        self._seen.draw(partial(_draw_obstacles, stream))
        self._routes.draw(partial(_draw_routes, stream))


def _draw_obstacles(stream: Any, seen: Sequence[tuple[float, Sequence[Track]]]) -> None:
    flat = [track for _, tracks in seen for track in tracks]
    columns = rr.Boxes3D.columns(
        half_sizes=np.array([track.size for track in flat]).reshape(-1, 3) / 2,
        centers=np.array([track.position_world for track in flat]).reshape(-1, 3),
        quaternions=[_upright(track.heading_world) for track in flat],
    )
    send_sets(stream, OBSTACLES, [time for time, _ in seen], columns, [len(tracks) for _, tracks in seen], lasting=True)


def _draw_routes(stream: Any, changes: Sequence[tuple[float, Sequence[Array]]]) -> None:
    columns = rr.LineStrips3D.columns(strips=[_on_floor(route) for _, routes in changes for route in routes])
    times, counts = [time for time, _ in changes], [len(routes) for _, routes in changes]
    send_sets(stream, ROUTE, times, columns, counts, lasting=True)


def _upright(heading: float) -> Any:
    return rr.Quaternion(xyzw=[0, 0, math.sin(heading / 2), math.cos(heading / 2)])


def _on_floor(route: Array) -> Array:
    return np.column_stack([route, np.full(len(route), _LIFT)])
