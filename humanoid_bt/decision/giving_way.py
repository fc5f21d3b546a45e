"""Giving way to what moves, and to what has come too near: when the robot waits, and where it steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.messages import Array
from humanoid_bt.decision.obstacles import SLACK, clear
from humanoid_bt.decision.surroundings import Surroundings
from humanoid_bt.robot.config import GaitConfig

_FORESIGHT = 3.0  # s of walking on, or of standing, that are looked at for what moves
_STOPS = 1.2  # s that it takes to see that it is to stop, and to stop
_SPEED = 0.2  # m/s at which the robot steps aside, in any direction
_PASSES = 6.0  # s in which nothing that moves is to come to the place to which it steps aside
_NEARER = 0.03  # m that something must be too near before the robot steps away from it
_RING = 0.05  # m between the rings of places to which it steps, the nearest first
_AROUND = np.arange(24) * (math.tau / 24)
_RINGS = np.concatenate(
    [radius * np.stack([np.cos(_AROUND), np.sin(_AROUND)], 1) for radius in np.arange(_RING, 1.0, _RING)]
)


class GivingWay:
    """To everything solid that the robot has seen.

    Args:
        around: all that, as of its last look.
        gait: how the robot walks.
        room: how near it lets anything come [m].
    """

    def __init__(self, around: Surroundings, gait: GaitConfig, room: float) -> None:
        self._around, self._gait, self._room = around, gait, room
        self._aside: Array | None = None  # where it steps to, shape (2,)

    def would_meet(self, here: Array, target: Array) -> list[str]:
        """Return what moves that the robot would meet if it walked on, and that it can still let pass, by name.

        It walks on for as long as it would also stop in time a moment later.

        Args:
            here: where it stands, shape (2,), world frame [m].
            target: where it walks to, straight on, shape (2,), world frame [m].
        """
        moving = self._around.moving
        if not moving:
            return []
        length = math.dist(here, target)
        speed = self._gait.step_forward / (self._gait.single_support + self._gait.double_support)
        arrives = min(length / speed, _FORESIGHT)
        way = (target - here) * (speed / max(length, 1e-6))  # in a second
        goes, stops = here + arrives * way, here + min(arrives, _STOPS) * way
        on, later = [(0.0, here), (arrives, goes), (_FORESIGHT, goes)], [(0.0, stops), (_FORESIGHT, stops)]
        names = self._around.obstacles.names
        return [names[i] for i in moving if self._meets(i, on) and self._meets(i, later)]

    def aside(self, here: Array) -> Array | None:
        """Return where to step so that what comes to a robot that waits goes past, shape (2,), world frame [m].

        The nearest place to where it stands, shape (2,); None if nothing comes there, or there is no such place. One
        that was chosen in the last tick is the first choice: what moves is seen a little differently each time.
        """
        around, moving, before = self._around.obstacles, self._around.moving, self._aside
        self._aside = None
        if not any(self._meets(i, [(0.0, here), (_FORESIGHT, here)]) for i in moving):
            return None
        places = here + _RINGS if before is None else np.concatenate([before[None], here + _RINGS])
        free = (around.distances(places) >= self._room).all(axis=1)
        places = places[np.logical_and(free, around.straight(here, places, self._room))]
        for passes in (_PASSES, _FORESIGHT):
            arrives = np.minimum(np.linalg.norm(places - here, axis=1, keepdims=True) / _SPEED, passes)
            way = [(0.0, here), (arrives, places), (passes, places)]
            found = np.flatnonzero(~np.array([self._meets(i, way) for i in moving]).any(axis=0))
            if len(found):
                self._aside = np.asarray(places[found[0]])
                break
        return self._aside

    def walk_on(self) -> None:
        """Forget where it stepped to: it walks on, and does not wait."""
        self._aside = None

    def away(self, here: Array, ignore: Sequence[str]) -> Array | None:
        """Return the nearest place at which nothing is too near, shape (2,), world frame [m].

        Args:
            here: where the robot stands, shape (2,), world frame [m].
            ignore: what may be as near as it likes.

        Returns:
            None if nothing is too near to where it stands, or if there is no such place.
        """
        around = self._around.obstacles
        if not len(around):
            return None
        beside = around.distances(here[None])[0]
        if all(name in ignore for name, room in zip(around.names, beside, strict=True) if room < self._room - _NEARER):
            return None
        places = here + _RINGS
        farther = (around.distances(places) >= np.minimum(self._room, beside + _RING)).all(axis=1)
        found = np.flatnonzero(np.logical_and(farther, around.straight(here, places, self._room)))
        return np.asarray(places[found[0]]) if len(found) else None

    def _meets(self, number: int, way: Sequence[tuple[Any, Array]]) -> NDArray[np.bool_]:
        """Return whether the robot would come too near to what moves.

        Args:
            number: of what moves.
            way: times [s] and places, shape (2,) or (n, 2) [m], at which the robot would be one after the other; times
                that are not the same for all places have the shape (n, 1).

        Returns:
            Shape (), or (n,).
        """
        velocity = self._around.velocities[number]
        seen = np.stack(np.broadcast_arrays(*(place - time * velocity for time, place in way)))
        beyond = self._around.obstacles.some([number]).beyond(seen.reshape(-1, 2)).reshape(*seen.shape[:-1], 8)
        room = np.minimum(self._room, beyond[0].max(axis=-1) - SLACK)
        return np.asarray(~clear(beyond[:-1], beyond[1:], room).all(axis=0))
