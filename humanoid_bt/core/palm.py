"""What targets of hands ask for, in the world; a palm's frame has x along its fingers and z where it faces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from humanoid_bt.core.geometry import quaternion, quaternion_product, rotation_matrix, turn_between, turn_of_axis
from humanoid_bt.core.messages import Array, HandTarget, PalmAxis, Pointing, Side, State

_AXIS: dict[PalmAxis, int] = {"fingers": 0, "facing": 2}  # columns of a palm's rotation matrix


def other_side(side: Side) -> Side:
    """Return the other side."""
    return "left" if side == "right" else "right"


def axis_of(frame: Array, axis: PalmAxis) -> Array:
    """Return an axis of a palm, shape (3,), whose frame is a rotation matrix, shape (3, 3)."""
    return np.asarray(frame[:, _AXIS[axis]])


def turn_left(frame: Array, orientation: Array | Pointing) -> float:
    """Return how far a palm, whose frame is a rotation matrix, shape (3, 3), is turned from an orientation [rad]."""
    if isinstance(orientation, Pointing):
        turn = turn_of_axis(axis_of(frame, orientation.axis), orientation.direction)
    else:
        turn = turn_between(quaternion(frame), orientation)
    return math.sqrt(turn @ turn)


def in_world(target: HandTarget, origin: Array, frame: Array) -> HandTarget:
    """Return a target that is relative to a palm, place shape (3,) and frame shape (3, 3), as one of the world."""
    position, orientation = origin + frame @ target.position, turned_with(frame, target.orientation)
    return replace(target, position=position, orientation=orientation, relative=False)


def turned_with(frame: Array, orientation: Array | Pointing | None) -> Array | Pointing | None:
    """Return an orientation that is given in a frame, shape (3, 3), as one of the world."""
    if orientation is None:
        return None
    if isinstance(orientation, Pointing):
        return Pointing(frame @ orientation.direction, orientation.axis)
    return quaternion_product(quaternion(frame), orientation)


def commanded(state: State, side: Side) -> HandTarget | None:
    """Return where a hand is to be in the world, by the command in force; None if nothing says so."""
    target, other = state.targets.get(f"{side}_hand"), other_side(side)
    if not isinstance(target, HandTarget):
        return None
    if not target.relative:
        return target
    if other not in state.hands:
        return None
    return in_world(target, state.hands[other], rotation_matrix(state.hand_orientations[other]))
