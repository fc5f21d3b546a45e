"""What expressions can ask of percepts and of the robot's state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from humanoid_bt.core.errors import any_of
from humanoid_bt.core.geometry import yaw_of
from humanoid_bt.core.messages import Gait, Mode, State
from humanoid_bt.perception.track import Track
from humanoid_bt.tree.expressions.quantities import NUMBER, TEXT, TRUTH, Type, number

Asked = TypeVar("Asked")
Answer = bool | float | str


@dataclass(frozen=True)
class Word(Generic[Asked]):
    """Something that can be asked.

    Attributes:
        doc: one line.
        type: of the answer.
        of: how it is found; None if it is not known.
        choices: all texts that the answer can be, none if it can be any.
    """

    doc: str
    type: Type
    of: Callable[[Asked], Answer | None]
    choices: tuple[str, ...] = ()


_GAITS, _MODES = tuple(gait.value for gait in Gait), tuple(mode.value for mode in Mode)
_M, _S, _RAD = number("m"), number("s"), number("rad")


def _yaw(track: Track) -> float | None:
    if (orientation := track.orientation_world) is not None:
        return yaw_of(orientation)
    return None if track.size is None else track.heading_world


PERCEPT: Mapping[str, Word[Track]] = {
    "distance": Word("Horizontal distance from the robot's stance.", _M, lambda track: track.distance),
    "bearing": Word("Direction from the stance's heading, left positive.", _RAD, lambda track: track.bearing),
    "height": Word("Height above the floor.", _M, lambda track: float(track.position_world[2])),
    "confidence": Word("Confidence, from 0 to 1.", NUMBER, lambda track: track.confidence),
    "age": Word("Time since it was seen.", _S, lambda track: track.age),
    "x": Word("Where it is in the world.", _M, lambda track: float(track.position_world[0])),
    "y": Word("Where it is in the world.", _M, lambda track: float(track.position_world[1])),
    "yaw": Word("How it is turned in the world, seen from above, if it is told.", _RAD, _yaw),
    "size": Word(
        "Longest edge of the box around it, if it is told.",
        _M,
        lambda track: None if track.size is None else float(track.size.max()),
    ),
    "class": Word("What kind of thing it is, if it is told.", TEXT, lambda track: track.class_name or None),
    "deviation": Word("Standard deviation of where it is, if it is told.", _M, lambda track: track.deviation),
}
"""``target.distance`` or ``distance(target)``: what can be asked of a percept that was seen."""

SEEN = "seen"
"""``seen(target)``: whether a percept was ever seen; the only question that an unseen one answers."""

STATE: Mapping[str, Word[State]] = {
    "time": Word("Time since the run began.", _S, lambda state: state.time),
    "standing": Word("Whether the robot stands, at rest, no step pending.", TRUTH, lambda state: state.base_settled),
    "gait": Word(f"What the legs do: {any_of(_GAITS)}.", TEXT, lambda state: state.gait.value, _GAITS),
    "mode": Word(f"What the supervisor allows: {any_of(_MODES)}.", TEXT, lambda state: state.mode.value, _MODES),
    "x": Word("Where the robot stands in the world.", _M, lambda state: float(state.stance[0])),
    "y": Word("Where the robot stands in the world.", _M, lambda state: float(state.stance[1])),
    "heading": Word("Where the stance points in the world.", _RAD, lambda state: float(state.stance[2])),
    "speed": Word(
        "Horizontal speed of the base.",
        number("m/s"),
        lambda state: math.hypot(state.base_linear_velocity[0], state.base_linear_velocity[1]),
    ),
    "com_height": Word("Height of the centre of mass.", _M, lambda state: float(state.com[2])),
    "touched": Word(
        "Largest force with which something pushes an arm or the torso; 0 where nothing does.",
        number("N"),
        lambda state: max((math.hypot(*contact.force) for contact in state.contacts.values()), default=0.0),
    ),
}
"""``state.standing``: what can be asked of the robot."""
