"""Simulated perception: what a camera in the head with a tracker behind it would publish."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from humanoid_bt.core.geometry import heading_of, rotation_matrix
from humanoid_bt.core.messages import Array, Percept, State, Truth
from humanoid_bt.core.units import readable
from humanoid_bt.perception.interface import Perception
from humanoid_bt.plant.scene import Box, Scene, random_stream
from humanoid_bt.plant.scene_config import PerceptConfig

_NEAR_CONFIDENCE = 0.95  # of a thing right before the eyes
_FAR_CONFIDENCE = 0.60  # of a thing at the end of the range
_FALL_EXPONENT = 3  # confidence hardly falls in the near half of the range
_LOST_CONFIDENCE = 0.08  # of a thing that is remembered, not seen
_ALONG = np.geomspace(0.05, 1.0, 8)[:, None]  # of the range, along the line of view, where walls are looked for
_PLAINLY, _DEVIATIONS = 0.1, 4.0  # m, standard deviations: so far inside of the view a place is plainly empty
_CONFIDENCE_NOISE = 0.01  # standard deviation
_CONFIDENCE_NOISE_LIMIT = 0.02  # bounded, so that a threshold's distance from the confidence means something


class SimulatedPerception(Perception):
    """Sees the scene's objects from where the robot's eyes are, as a tracker does.

    A thing is published from the moment it was first seen. While it is hidden, or out of view or range, it is
    published where it was last seen, with low confidence; once that place was plainly in view, and the thing not, with
    none. Nothing but where it is and the scene's script is read, so perception can run in a process of its own.

    Of a solid thing it tells the size too, and sees it when any part of it is in sight.

    Args:
        scene: where things are, and what is published of them.
        seed: of the noise; each percept has its own random numbers.
    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self._scene = scene
        self._numbers = {name: random_stream(seed, "percept", name) for name in scene.config.percepts}
        self._last_seen: dict[str, Array] = {}
        self._gone: set[str] = set()  # from where it was last seen
        self.names = list(scene.config.percepts)
        self._unseen = {name: _at_first(config) for name, config in scene.config.percepts.items()}
        self._looked = False  # the first look is whole: what sees anything at all has looked before the run

    @property
    def unseen(self) -> Mapping[str, str]:
        """The percepts that were never published so far, and why."""
        return self._unseen

    def observe(self, robot: Truth, _state: State | None = None) -> list[Percept]:
        """Return what is published now; call it once per perception period.

        Positions are in the robot's base frame at that time.
        """
        percepts: list[Percept] = []
        turn = rotation_matrix(robot.base_quaternion)
        for name, config in self._scene.config.percepts.items():
            numbers = self._numbers[name]
            # All are drawn every time, so that what the robot sees does not change the noise that comes later.
            may_drop = self._looked or config.drop_out == 1
            dropped = numbers.random() < config.drop_out and may_drop
            position_noise, confidence_noise = numbers.standard_normal(3), numbers.standard_normal()
            if dropped:
                continue
            position = self._scene.object_position(config.object, robot.time)
            box = self._scene.box(config.object)
            offset = position - robot.gaze_position
            distance = math.sqrt(offset @ offset)
            hidden = self._scene.hidden(config.object, robot.time)
            why_not = "hidden" if hidden else _out_of_sight(offset, distance, robot, config)
            if why_not and box and not hidden and _part_in_sight(box, offset, robot, config):
                why_not = ""
            if not why_not:
                self._unseen.pop(name, None)
                self._gone.discard(name)
                self._last_seen[name] = position + position_noise * (config.noise + config.noise_per_meter * distance)
                fall = min(distance / config.range, 1.0) ** _FALL_EXPONENT
                confidence = _NEAR_CONFIDENCE - (_NEAR_CONFIDENCE - _FAR_CONFIDENCE) * fall
            else:
                confidence = _LOST_CONFIDENCE
            if name not in self._last_seen:
                self._unseen[name] = why_not
                continue
            if why_not and not hidden and _plainly_in_sight(self._last_seen[name] - robot.gaze_position, robot, config):
                self._gone.add(name)
            noise = _CONFIDENCE_NOISE * float(confidence_noise)
            confidence += min(max(noise, -_CONFIDENCE_NOISE_LIMIT), _CONFIDENCE_NOISE_LIMIT)
            if name in self._gone:
                confidence = 0.0
            in_base = turn.T @ (self._last_seen[name] - robot.base_position)
            size, heading = (box.size, box.heading - heading_of(turn)) if box else (None, 0.0)
            percepts.append(Percept(name, robot.time, in_base, confidence, size, heading))
        self._looked = True
        return percepts


def _at_first(config: PerceptConfig) -> str:
    """Return why something was never seen, as long as no look says why."""
    return "every observation is dropped" if config.drop_out == 1 else "perception has not looked yet"


def _part_in_sight(box: Box, offset: Array, robot: Truth, config: PerceptConfig) -> bool:
    """Return whether any part of a box whose middle is at an offset from the eyes (world frame [m]) is seen.

    That is a corner, or, of a wall whose corners are all out of sight, what is nearest to the line of view.
    """
    near = box.nearest(config.range * _ALONG * robot.gaze_direction - offset)
    parts = offset + np.concatenate([box.corners, near])
    ahead, aside, above = np.array(_axes(robot)) @ parts.T
    wide, high = config.field_of_view / 2, config.vertical_field_of_view / 2
    horizontal, vertical = np.arctan2(aside, ahead), np.arctan2(above, np.hypot(ahead, aside))
    seen = (np.linalg.norm(parts, axis=1) <= config.range) & (np.abs(horizontal) <= wide) & (np.abs(vertical) <= high)
    return bool(seen.any())


def _plainly_in_sight(offset: Array, robot: Truth, config: PerceptConfig) -> bool:
    """Return whether a place at an offset from the eyes (world frame [m]) is farther inside of the view than noise."""
    distance = math.sqrt(offset @ offset)
    room = _PLAINLY + _DEVIATIONS * (config.noise + config.noise_per_meter * distance)
    return distance > room and not _out_of_sight(offset, distance + room, robot, config, math.asin(room / distance))


def _out_of_sight(offset: Array, distance: float, robot: Truth, config: PerceptConfig, inside: float = 0.0) -> str:
    """Return why a position, seen from the eyes (world frame [m]), is beyond the range or the angles of view, or "".

    The angles count so much inside of the view [rad].
    """
    if distance > config.range:
        return f"out of range: {readable(distance, 'm')} away, seen up to {readable(config.range, 'm')}"
    x, y, z = offset.tolist()
    ahead, aside, above = (x * u + y * v + z * w for u, v, w in _axes(robot))
    horizontal, vertical = math.atan2(aside, ahead), math.atan2(above, math.hypot(ahead, aside))
    if abs(horizontal) > config.field_of_view / 2 - inside:
        return _out_of_view(horizontal, "left of", "right of", config.field_of_view)
    if abs(vertical) > config.vertical_field_of_view / 2 - inside:
        return _out_of_view(vertical, "above", "below", config.vertical_field_of_view)
    return ""


def _axes(robot: Truth) -> list[list[float]]:
    """Return what is ahead of the eyes, to their left and above, as unit vectors, world frame."""
    fx, fy, fz = robot.gaze_direction.tolist()
    lx, ly, lz = -fy, fx, 0.0  # what is up, across forward
    if math.hypot(lx, ly) < 1e-6:  # looking straight up or down: the body says where left is
        lx, ly, lz = rotation_matrix(robot.base_quaternion)[:, 1].tolist()
    length = math.sqrt(lx * lx + ly * ly + lz * lz)
    lx, ly, lz = lx / length, ly / length, lz / length
    return [[fx, fy, fz], [lx, ly, lz], [fy * lz - fz * ly, fz * lx - fx * lz, fx * ly - fy * lx]]


def _out_of_view(angle: float, positive: str, negative: str, field_of_view: float) -> str:
    where = positive if angle > 0 else negative
    seen = readable(field_of_view / 2, "rad")
    return f"out of view: {readable(abs(angle), 'rad')} {where} the gaze, seen up to {seen}"
