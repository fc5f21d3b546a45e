"""What the feet on the ground can bear: pressure inside of their soles, weight shared between them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from humanoid_bt.core.compiled import compiled, inlined
from humanoid_bt.core.messages import Array, Side


@inlined
def _inside(sole: Array, x: float, y: float, half: Array) -> tuple[float, float]:
    """Return the point of a rectangle around a sole that is nearest to (x, y)."""
    at_x, at_y = sole[0], sole[1]
    cos, sin = math.cos(sole[2]), math.sin(sole[2])
    x, y = x - at_x, y - at_y
    ahead = min(max(cos * x + sin * y, -half[0]), half[0])
    aside = min(max(cos * y - sin * x, -half[1]), half[1])
    return at_x + cos * ahead - sin * aside, at_y + sin * ahead + cos * aside


@inlined
def shared(
    x: float, y: float, left: Array, right: Array, left_stands: bool, right_stands: bool, half: Array, cop: Array
) -> float:
    """Write each foot's centre of pressure for a zero-moment point; return the right foot's share of the weight.

    Args:
        x, y: the zero-moment point, world frame [m]; the feet come as near to it as they can.
        left, right: poses of the soles, shape (3,), world frame.
        left_stands, right_stands: whether each foot is on the ground.
        half: length and width of the part of a sole that may bear pressure, halved, shape (2,) [m].
        cop: is written: of (left, right), shape (2, 2), world frame [m].
    """
    if not right_stands:
        cop[0, 0], cop[0, 1] = _inside(left, x, y, half)
        cop[1] = right[:2]
        return 0.0
    if not left_stands:
        cop[1, 0], cop[1, 1] = _inside(right, x, y, half)
        cop[0] = left[:2]
        return 1.0
    line_x, line_y = right[0] - left[0], right[1] - left[1]
    along = (x - left[0]) * line_x + (y - left[1]) * line_y
    on_right: float = min(max(along / (line_x**2 + line_y**2), 0.0), 1.0)
    aside_x, aside_y = x - (left[0] + on_right * line_x), y - (left[1] + on_right * line_y)
    cop[0, 0], cop[0, 1] = _inside(left, left[0] + aside_x, left[1] + aside_y, half)
    cop[1, 0], cop[1, 1] = _inside(right, right[0] + aside_x, right[1] + aside_y, half)
    return on_right


@compiled("f8(f8[::1], f8[::1], f8[::1], f8[::1])")
def _beyond(point: Array, left: Array, right: Array, half: Array) -> float:
    cop = np.empty((2, 2))
    on_right = shared(point[0], point[1], left, right, True, True, half, cop)
    x = cop[0, 0] + on_right * (cop[1, 0] - cop[0, 0])
    y = cop[0, 1] + on_right * (cop[1, 1] - cop[0, 1])
    return math.hypot(x - point[0], y - point[1])


def beyond(point: Array, soles: Mapping[Side, Array], half: Array) -> float:
    """Return how far a point, shape (2,), is from where the feet can bear pressure [m]; see :func:`shared`."""
    return _beyond(point, soles["left"], soles["right"], half)
