"""What the feet on the ground can bear: pressure inside of their soles, weight shared between them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from humanoid_bt.control.body.footsteps import OTHER
from humanoid_bt.control.body.planar import inside
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
            cop = inside(soles[side], wanted, *half)
            return {side: 1.0, OTHER[side]: 0.0}, {side: cop, OTHER[side]: soles[OTHER[side]][:2]}
    (left_x, left_y, _), (right_x, right_y, _) = soles["left"].tolist(), soles["right"].tolist()
    x, y = wanted.tolist()
    line_x, line_y = right_x - left_x, right_y - left_y
    along = (x - left_x) * line_x + (y - left_y) * line_y
    on_right = min(max(along / (line_x**2 + line_y**2), 0.0), 1.0)
    aside = np.array([x - (left_x + on_right * line_x), y - (left_y + on_right * line_y)])
    cop_left = inside(soles["left"], soles["left"][:2] + aside, *half)
    cop_right = inside(soles["right"], soles["right"][:2] + aside, *half)
    return {"left": 1.0 - on_right, "right": on_right}, {"left": cop_left, "right": cop_right}
