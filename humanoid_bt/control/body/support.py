"""What the feet on the ground can bear: pressure inside of their soles, weight shared between them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from humanoid_bt.control.body.footsteps import OTHER
from humanoid_bt.core.messages import SIDES, Array, Side


def shared(
    wanted: Array, soles: Mapping[Side, Array], contact: Mapping[Side, bool], half: tuple[float, float]
) -> tuple[dict[Side, float], dict[Side, Array]]:
    """Return each foot's share of the weight and its centre of pressure, shape (2,), for a zero-moment point.

    Args:
        wanted: the zero-moment point, shape (2,), world frame [m]; the feet come as near to it as they can.
        soles: poses, shape (3,), world frame.
        contact: whether each foot is on the ground.
        half: length and width of the part of a sole that may bear pressure, halved [m].
    """
    for side in SIDES:
        if not contact[OTHER[side]]:
            x, y = wanted.tolist()
            cop: Array = np.array(_inside(soles[side], x, y, half))
            return {side: 1.0, OTHER[side]: 0.0}, {side: cop, OTHER[side]: soles[OTHER[side]][:2]}
    on_right, left, right = _on_both(wanted, soles, half)
    return {"left": 1.0 - on_right, "right": on_right}, {"left": np.array(left), "right": np.array(right)}


def beyond(point: Array, soles: Mapping[Side, Array], half: tuple[float, float]) -> float:
    """Return how far a point, shape (2,), is from where the feet can bear pressure [m]; see :func:`shared`."""
    on_right, left, right = _on_both(point, soles, half)
    x, y = (one + on_right * (other - one) for one, other in zip(left, right, strict=True))
    return math.dist((x, y), point.tolist())


def _on_both(
    wanted: Array, soles: Mapping[Side, Array], half: tuple[float, float]
) -> tuple[float, tuple[float, float], tuple[float, float]]:
    """Return the right foot's share, and where the left and the right foot bear it."""
    (left_x, left_y, _), (right_x, right_y, _) = soles["left"].tolist(), soles["right"].tolist()
    x, y = wanted.tolist()
    line_x, line_y = right_x - left_x, right_y - left_y
    along = (x - left_x) * line_x + (y - left_y) * line_y
    on_right = min(max(along / (line_x**2 + line_y**2), 0.0), 1.0)
    aside_x, aside_y = x - (left_x + on_right * line_x), y - (left_y + on_right * line_y)
    left = _inside(soles["left"], left_x + aside_x, left_y + aside_y, half)
    return on_right, left, _inside(soles["right"], right_x + aside_x, right_y + aside_y, half)


def _inside(sole: Array, x: float, y: float, half: tuple[float, float]) -> tuple[float, float]:
    """Return the point of a rectangle around a sole that is nearest to (x, y)."""
    at_x, at_y, heading = sole.tolist()
    cos, sin = math.cos(heading), math.sin(heading)
    x, y = x - at_x, y - at_y
    ahead = min(max(cos * x + sin * y, -half[0]), half[0])
    aside = min(max(cos * y - sin * x, -half[1]), half[1])
    return at_x + cos * ahead - sin * aside, at_y + sin * ahead + cos * aside
