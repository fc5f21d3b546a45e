"""What is known of one thing that was seen: where it is, how long ago that was, how sure it is."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.core.geometry import quaternion_product, rotation_matrix
from humanoid_bt.core.messages import Array, Percept, State


class Track:
    """The latest percept of one thing, placed in the world, as it was at the start of a tick.

    What depends on where the robot stands is worked out when it is read. All nodes of a tick see the same one: nothing
    of it can be set.

    Attributes:
        name: the percept's name.
        stamp: when it was seen [s].
        age: how long ago that is [s].
        position_world: shape (3,) [m], from the base pose at the time it was seen.
        position_base: shape (3,), in the robot's base frame now [m].
        distance: horizontal distance from the robot's stance (middle between the feet) [m].
        bearing: direction of it from the stance's heading, left positive [rad].
        confidence: in [0, 1].
        gone: whether it is known to be there no longer: its confidence is 0.
        size: of a solid thing, shape (3,): length, width, height of the upright box around it [m]; None of any other.
        heading_world: where the length of that box points to [rad].
        orientation_world: of the thing's own frame, wxyz, shape (4,), in the world; None if it is not known.
        class_name: what kind of thing it is, "" if it is not known.
        covariance_world: of its position, world frame, shape (3, 3) [m^2]; None if it is not known.
        deviation: standard deviation of its position in the direction in which that is largest [m]; None likewise.
    """

    __slots__ = ("_age", "_heading", "_percept", "_position", "_state", "_turn")

    def __init__(
        self,
        percept: Percept,
        position_world: Array,
        age: float,
        state: State,
        heading_world: float = 0.0,
        *,
        turn: Array | None = None,
    ) -> None:
        self._percept = percept
        self._state = state
        self._turn = turn  # of the base when it was seen, wxyz; None where the percept is given in the world
        self._age = age
        self._position = position_world
        self._heading = heading_world

    def __repr__(self) -> str:
        return (
            f"<Track {self.name!r}: {self.distance:.2f} m away, {self.age:.2f} s old, confidence {self.confidence:.2f}>"
        )

    @property
    def name(self) -> str:  # noqa: D102 (documented above, as the others)
        return self._percept.name

    @property
    def stamp(self) -> float:  # noqa: D102 (as name)
        return self._percept.stamp

    @property
    def age(self) -> float:  # noqa: D102 (as name)
        return self._age

    @property
    def position_world(self) -> Array:  # noqa: D102 (as name)
        return self._position

    @property
    def heading_world(self) -> float:  # noqa: D102 (as name)
        return self._heading

    @property
    def confidence(self) -> float:  # noqa: D102 (as name)
        return self._percept.confidence

    @property
    def gone(self) -> bool:  # noqa: D102 (as name)
        return self.confidence <= 0.0

    @property
    def size(self) -> Array | None:  # noqa: D102 (as name)
        return self._percept.size

    @property
    def orientation_world(self) -> Array | None:  # noqa: D102 (as name)
        turn = self._percept.orientation
        return turn if turn is None or self._turn is None else quaternion_product(self._turn, turn)

    @property
    def class_name(self) -> str:  # noqa: D102 (as name)
        return self._percept.class_name

    @property
    def covariance_world(self) -> Array | None:  # noqa: D102 (as name)
        covariance = self._percept.covariance
        if covariance is None or self._turn is None:
            return covariance
        turn = rotation_matrix(self._turn)
        return np.asarray(turn @ covariance @ turn.T)

    @property
    def deviation(self) -> float | None:  # noqa: D102 (as name)
        covariance = self._percept.covariance
        return None if covariance is None else math.sqrt(max(0.0, float(np.linalg.eigvalsh(covariance)[-1])))

    @property
    def position_base(self) -> Array:  # noqa: D102 (as name)
        state = self._state
        return rotation_matrix(state.base_quaternion).T @ (self._position - state.base_position)

    @property
    def distance(self) -> float:  # noqa: D102 (as name)
        return math.hypot(*self._offset())

    @property
    def bearing(self) -> float:  # noqa: D102 (as name)
        x, y = self._offset()
        bearing = math.atan2(y, x) - float(self._state.stance[2])
        return (bearing + math.pi) % (2 * math.pi) - math.pi

    def _offset(self) -> tuple[float, float]:
        x, y, _ = self._position.tolist()
        stance_x, stance_y, _ = self._state.stance.tolist()
        return x - stance_x, y - stance_y
