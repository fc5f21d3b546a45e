"""What stands around, seen from above: rectangles with a name, and how far points and straight ways are from them.

Distances are measured along the eight directions of a compass that is turned with each rectangle: what is a distance
away from one is outside of an octagon around it. That is a little nearer than as the crow flies, at a corner by at most
8 %, and what is not within it can be told for hundreds of straight ways at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.messages import Array

_ANGLES = np.arange(8) * (np.pi / 4)
_COMPASS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], 1)
_BETWEEN = np.stack([np.cos(_ANGLES + np.pi / 8), np.sin(_ANGLES + np.pi / 8)], 1) / np.cos(np.pi / 8)
_CORNERS = np.array([[1, 1], [1, 1], [-1, 1], [-1, 1], [-1, -1], [-1, -1], [1, -1], [1, -1]], dtype=float)
SLACK = 1e-3
"""What a way may come nearer to something than where it begins or ends [m]."""

_TINY = 1e-9
_NOTHING = 1e-300  # keeps a division by zero away, and is lost beside any other number


@dataclass(frozen=True)
class Obstacles:
    """Rectangles on the floor, world frame.

    Attributes:
        names: n of them.
        middles: shape (n, 2) [m].
        halves: half of length and width, shape (n, 2) [m].
        headings: of the lengths, shape (n,) [rad].
    """

    names: Sequence[str]
    middles: Array
    halves: Array
    headings: Array

    def __len__(self) -> int:
        return len(self.names)

    def some(self, which: Sequence[int]) -> Obstacles:
        """Return those with these numbers."""
        chosen = list(which)
        names = [self.names[i] for i in chosen]
        return Obstacles(names, self.middles[chosen], self.halves[chosen], self.headings[chosen])

    def beyond(self, points: Array) -> Array:
        """Return how far points, shape (m, 2), are from each rectangle in each direction: shape (m, n, 8) [m]."""
        return np.asarray(np.einsum("mx,nkx->mnk", points, self._normals) - self._offsets)

    def distances(self, points: Array) -> Array:
        """Return how far points, shape (m, 2), are from each rectangle: shape (m, n) [m], negative inside."""
        return np.asarray(self.beyond(points).max(axis=2))

    def toward(self, points: Array) -> Array:
        """Return how far a metre from points, shape (m, 2), to each middle goes in each direction: shape (m, n, 8)."""
        ways = self.middles - points[:, None]
        ways /= np.maximum(np.linalg.norm(ways, axis=2, keepdims=True), _TINY)
        return np.asarray(np.einsum("mnx,nkx->mnk", ways, self._normals).clip(-1.0, 1.0))

    def straight(self, start: Array, ends: Array, room: float) -> NDArray[np.bool_]:
        """Return which straight ways from one place keep a distance from everything, shape (m,).

        From what the start or the end is nearer to, the way keeps as far as the farther of the two.

        Args:
            start: shape (2,), world frame [m].
            ends: shape (m, 2), world frame [m].
            room: the distance [m].
        """
        if not len(self):
            return np.ones(len(ends), dtype=bool)
        begins, ended = self.beyond(start[None]), self.beyond(ends)
        beside = np.minimum(begins.max(axis=2), ended.max(axis=2)) - SLACK
        return np.asarray(clear(begins, ended, np.minimum(room, beside)).all(axis=1))

    def corners(self, room: float) -> Array:
        """Return the points at which ways turn that keep this far [m] from each rectangle: shape (n, 8, 2)."""
        local = _CORNERS * self.halves[:, None] + room * (1 + 1e-6) * _BETWEEN
        return np.asarray(self.middles[:, None] + np.einsum("nka,nax->nkx", local, self._axes))

    @cached_property
    def _axes(self) -> Array:
        """Along and across each rectangle, shape (n, 2, 2)."""
        cos, sin = np.cos(self.headings), np.sin(self.headings)
        return np.stack([np.stack([cos, sin], 1), np.stack([-sin, cos], 1)], 1)

    @cached_property
    def _normals(self) -> Array:
        """The directions of each compass, shape (n, 8, 2)."""
        return np.asarray(np.einsum("ka,nax->nkx", _COMPASS, self._axes))

    @cached_property
    def _offsets(self) -> Array:
        """How far each rectangle reaches in each direction from the world's origin, shape (n, 8) [m]."""
        reach = np.abs(_COMPASS) @ self.halves.T
        return np.asarray(np.einsum("nx,nkx->nk", self.middles, self._normals) + reach.T)


def clear(starts: Array, ends: Array, room: Array | float) -> NDArray[np.bool_]:
    """Return which straight ways keep a distance from which obstacles.

    Args:
        starts, ends: of the ways, as :meth:`Obstacles.beyond` gives them: shapes that go together with (m, n, 8) [m].
        room: the distance, a shape that goes together with (m, n) [m].

    Returns:
        Shape (m, n).
    """
    limit = np.asarray(room)[..., None] - _TINY
    start, end = starts - limit, ends - limit
    before, after = np.maximum(start, 0.0), np.maximum(end, 0.0)  # how far outside of each side it begins and ends
    # the shares of the way before it is inside of all sides, and after that; 1 where it stays outside of one
    enters = (before / (before - np.minimum(end, -_NOTHING))).max(axis=-1)
    leaves = (after / (after - np.minimum(start, -_NOTHING))).max(axis=-1)
    return np.asarray(enters + leaves >= 1.0)
