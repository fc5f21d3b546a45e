"""Rotations, for every layer. Quaternions are (w, x, y, z)."""

from __future__ import annotations

import numpy as np

from humanoid_bt.messages import Array


def rotation_matrix(quaternion: Array) -> Array:
    """Return the matrix, shape (3, 3), that turns vectors as a unit quaternion, shape (4,), does."""
    w, x, y, z = quaternion.tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
