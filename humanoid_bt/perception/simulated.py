"""Simulated perception: what a camera in the head with a tracker behind it would publish."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Array, Percept, State
from humanoid_bt.plant.scene import Scene, random_stream
from humanoid_bt.plant.scene_config import PerceptConfig

_NEAR_CONFIDENCE = 0.95  # of a thing right before the eyes
_FAR_CONFIDENCE = 0.60  # of a thing at the end of the range
_FALL_EXPONENT = 3  # confidence hardly falls in the near half of the range
_LOST_CONFIDENCE = 0.08  # of a thing that is remembered, not seen
_CONFIDENCE_NOISE = 0.01  # standard deviation
_CONFIDENCE_NOISE_LIMIT = 0.02  # bounded, so that a threshold's distance from the confidence means something


class SimulatedPerception:
    """Sees the scene's objects from where the robot's eyes are, as a tracker does.

    A thing is published from the moment it was first seen. While it is hidden, or out of view or range, it is
    published where it was last seen, with low confidence. Nothing but the state and the scene's script is read,
    so perception can run in a process of its own.

    Args:
        scene: where things are, and what is published of them.
        seed: of the noise; each percept has its own random numbers.
    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self._scene = scene
        self._numbers = {name: random_stream(seed, "percept", name) for name in scene.config.percepts}
        self._last_seen: dict[str, Array] = {}

    def observe(self, state: State) -> list[Percept]:
        """Return what is published at the state's time; call it once per perception period.

        Positions are in the robot's base frame at that time.
        """
        percepts: list[Percept] = []
        for name, config in self._scene.config.percepts.items():
            numbers = self._numbers[name]
            # All are drawn every time, so that what the robot sees does not change the noise that comes later.
            dropped = numbers.random() < config.drop_out
            position_noise, confidence_noise = numbers.standard_normal(3), numbers.standard_normal()
            if dropped:
                continue
            position = self._scene.object_position(config.object, state.time)
            distance = float(np.linalg.norm(position - state.gaze_position))
            hidden = self._scene.hidden(config.object, state.time)
            if not hidden and distance <= config.range and _in_view(position, state, config):
                self._last_seen[name] = position + position_noise * (config.noise + config.noise_per_meter * distance)
                fall = (distance / config.range) ** _FALL_EXPONENT
                confidence = _NEAR_CONFIDENCE - (_NEAR_CONFIDENCE - _FAR_CONFIDENCE) * fall
            else:
                confidence = _LOST_CONFIDENCE
            if name not in self._last_seen:
                continue
            offset = _CONFIDENCE_NOISE * float(confidence_noise)
            confidence += min(max(offset, -_CONFIDENCE_NOISE_LIMIT), _CONFIDENCE_NOISE_LIMIT)
            in_base = rotation_matrix(state.base_quaternion).T @ (self._last_seen[name] - state.base_position)
            percepts.append(Percept(name, state.time, in_base, confidence))
        return percepts


def _in_view(position: Array, state: State, config: PerceptConfig) -> bool:
    """Return whether a position (world frame [m]) lies within the angles of view around the gaze's direction."""
    forward = state.gaze_direction
    left = np.cross([0.0, 0.0, 1.0], forward)
    if np.linalg.norm(left) < 1e-6:  # looking straight up or down: the body says where left is
        left = rotation_matrix(state.base_quaternion)[:, 1]
    left = left / np.linalg.norm(left)
    offset = position - state.gaze_position
    ahead, aside, above = float(offset @ forward), float(offset @ left), float(offset @ np.cross(forward, left))
    horizontal, vertical = math.atan2(aside, ahead), math.atan2(above, math.hypot(ahead, aside))
    return abs(horizontal) <= config.field_of_view / 2 and abs(vertical) <= config.vertical_field_of_view / 2
