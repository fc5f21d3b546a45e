"""The frame of a palm: x where the fingers point, z where the palm faces, y = z x x."""

from __future__ import annotations

import numpy as np

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array, Side
from humanoid_bt.robot.config import RobotConfig

_LEAST = 1e-6  # m, length of a direction
_SIDEWAYS: dict[Side, Array] = {"left": np.array([0.0, -1.0, 0.0]), "right": np.array([0.0, 1.0, 0.0])}
_DOWN = np.array([0.0, 0.0, -1.0])
_ALIKE = 0.9  # cosine of two directions of which one does not say how the hand is turned about the other


def palm_axes(config: RobotConfig, side: Side) -> Array:
    """Return the rotation from a palm's frame to that of its body, shape (3, 3).

    What ``robot.yaml`` does not say is taken from the palm's place: the fingers point there from the body's origin, and
    the palm faces the other side, as that of an arm that hangs; where the fingers point to the side, it faces down.

    Raises:
        UserError: a direction is zero, or the palm faces where the fingers point.
    """
    hand = config.hands[side]
    place = np.array(hand.position)
    fingers = _unit(config, side, "fingers", hand.fingers)
    if fingers is None:
        length = float(np.linalg.norm(place))
        fingers = place / length if length > _LEAST else np.array([1.0, 0.0, 0.0])
    facing = _unit(config, side, "facing", hand.facing)
    if facing is None:
        facing = _DOWN if abs(float(fingers @ _SIDEWAYS[side])) > _ALIKE else _SIDEWAYS[side]
    elif abs(float(fingers @ facing)) > _ALIKE:
        message = f"the {side} palm faces where its fingers point"
        raise UserError(message, config.place("hands", side, "facing"), "a direction across the fingers", "site-off")
    facing = facing - (facing @ fingers) * fingers
    facing = facing / np.linalg.norm(facing)
    axes: Array = np.column_stack([fingers, np.cross(facing, fingers), facing])
    axes.setflags(write=False)
    return axes


def _unit(config: RobotConfig, side: Side, what: str, given: tuple[float, float, float] | None) -> Array | None:
    if given is None:
        return None
    length = float(np.linalg.norm(given))
    if length < _LEAST:
        raise UserError(f"{what!r} is no direction", config.place("hands", side, what), "as [1, 0, 0]", "out-of-range")
    return np.array(given) / length
