"""What the head camera sees: colours and depths, and from where, as control believes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.messages import Array


@dataclass(frozen=True)
class Picture:
    """A picture of the head camera, a pinhole without distortion whose axis goes through the middle.

    The eye's frame has x along the axis, y to the left and z up in the picture.

    Attributes:
        color: red, green, blue of each pixel, shape (height, width, 3), uint8; the first row is the upper one.
        depth: along the axis, shape (height, width) [m]; infinite where nothing is.
        focal: focal length [pixels].
        position: of the eye, as control believes it, in the base frame, shape (3,) [m].
        rotation: from the eye's frame to the base frame, likewise, shape (3, 3).
    """

    color: NDArray[np.uint8]
    depth: NDArray[np.float32]
    focal: float
    position: Array
    rotation: Array

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [pixels]."""
        height, width = self.depth.shape
        return width, height

    def rays(self, columns: Any, rows: Any) -> Array:
        """Return where pixels look to, shape (..., 3), in the base frame, with length 1 along the camera's axis.

        Args:
            columns, rows: of pixels, counted from the upper left one; fractions lie between pixels.
        """
        width, height = self.size
        left = ((width - 1) / 2 - np.asarray(columns, dtype=float)) / self.focal
        up = ((height - 1) / 2 - np.asarray(rows, dtype=float)) / self.focal
        return np.asarray(np.stack([np.ones_like(left), left, up], axis=-1) @ self.rotation.T)

    def point(self, column: float, row: float, depth: float) -> Array:
        """Return what a pixel shows at a depth along the axis [m]: shape (3,), in the base frame [m]."""
        return np.asarray(self.position + depth * self.rays(column, row))
