"""What a robot stands on: a plane, perhaps tilted, perhaps with flat plates lying on it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from humanoid_bt.core.messages import Array
from humanoid_bt.robot.published import PLAIN

FLOOR = "hbt_floor"
"""The floor's geom, its material and its texture: robots have names of their own."""

ANY = (1 << 31) - 1
"""Contype and conaffinity of what all shapes touch that touch anything: models use other bits than the first, too."""

_CELL = 0.5  # m: side of the squares in which there is a plate at most
_REACH = 4.0  # m from the start to the sides of the field of plates
_FREE = 0.5  # m around the start: the robot begins with flat feet
_SHARE = 0.7  # of the squares have a plate
_SIDES = (0.15, 0.35)  # m: lengths and widths; the longest diagonal fits into a square
_PLATE_COLOR = (0.52, 0.47, 0.4, 1.0)


@dataclass(frozen=True)
class Floor:
    """A floor. Where it is tilted, it goes through the robot's start, and the robot starts with its feet flat on it.

    Attributes:
        slope: how steep it is [rad].
        uphill: where it rises, a direction in the world [rad].
        plates: how thick the plates on it are [m]; 0 for none.
    """

    slope: float = 0.0
    uphill: float = 0.0
    plates: float = 0.0

    def add_to(self, spec: mujoco.MjSpec, start: tuple[float, float, float], numbers: np.random.Generator) -> None:
        """Add the floor to a model.

        Args:
            spec: the model; it has the material :data:`FLOOR`.
            start: x, y [m] of the middle between the robot's feet at the beginning, heading [rad], world frame.
            numbers: draw where the plates lie.
        """
        origin, tilt = np.array([start[0], start[1], 0.0]), self._tilt(self.uphill)
        # torsional friction keeps a foot loaded at a corner from spinning there; soles with a priority say their own
        touch = {"friction": [1, 0.03, 0.0001], "condim": 4, "contype": ANY, "conaffinity": ANY}
        spec.worldbody.add_geom(
            PLAIN,
            name=FLOOR,
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            pos=origin - _turned(origin, tilt),
            quat=tilt,
            size=[20, 20, 0.1],
            material=FLOOR,
            **touch,
        )
        for number, (x, y, yaw, length, width) in enumerate(self._plates(numbers)):
            turned = np.zeros(4)
            mujoco.mju_mulQuat(turned, tilt, np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]))
            spec.worldbody.add_geom(
                PLAIN,
                name=f"hbt_plate_{number}",
                type=mujoco.mjtGeom.mjGEOM_BOX,
                pos=origin + _turned(np.array([x, y, self.plates / 2]), tilt),
                quat=turned,
                size=[length / 2, width / 2, self.plates / 2],
                rgba=_PLATE_COLOR,
                **touch,
            )

    def under(self, standing: Array, heading: float) -> Array:
        """Return a configuration that stands on a level floor at the origin as it stands on this one.

        Args:
            standing: shape (7 + nj,), with the middle between the feet at the origin.
            heading: where the robot will face in the world [rad].
        """
        tilt = self._tilt(self.uphill - heading)
        tilted = standing.copy()
        tilted[:3] = _turned(standing[:3], tilt)
        mujoco.mju_mulQuat(tilted[3:7], tilt, standing[3:7])
        return tilted

    def _tilt(self, uphill: float) -> Array:
        """Return the turn, as a quaternion, that brings a level floor to where this one is."""
        turn = np.zeros(4)
        mujoco.mju_axisAngle2Quat(turn, np.array([math.sin(uphill), -math.cos(uphill), 0.0]), self.slope)
        return turn

    def _plates(self, numbers: np.random.Generator) -> Iterator[Array]:
        """Yield where plates lie, seen from the start, none over another: x, y [m], yaw [rad], length, width [m]."""
        if not self.plates:
            return
        for corner in np.ndindex(*[round(2 * _REACH / _CELL)] * 2):
            there, yaw, sides = numbers.random() < _SHARE, numbers.uniform(0, math.tau), numbers.uniform(*_SIDES, 2)
            room = (_CELL - math.hypot(*sides)) / 2  # to each side of the middle of its square
            place = (np.array(corner) + 0.5) * _CELL - _REACH + numbers.uniform(-room, room, 2)
            if there and math.hypot(*place) > _FREE + _CELL / 2:
                yield np.array([*place, yaw, *sides])


def _turned(vector: Array, turn: Array) -> Array:
    after = np.zeros(3)
    mujoco.mju_rotVecQuat(after, vector, turn)
    return after
