"""Percepts that a test dictates."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import Any

import numpy as np

from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Array, Percept, Truth


class ScriptedPerception:
    """Percepts that a test dictates: exact positions, at 10 Hz, from any place in the world."""

    unseen: Mapping[str, str] = types.MappingProxyType({})  # what the test does not show, it does not offer

    def __init__(self) -> None:
        self._seen: dict[str, tuple[Array, float]] = {}

    def see(self, name: str, position: Any, confidence: float) -> None:
        """Publish a thing at a position, shape (3,), world frame [m], from now on."""
        self._seen[name] = (np.array(position, dtype=float), confidence)

    def lose(self, name: str) -> None:
        """Publish nothing of a thing from now on; its last percept grows old."""
        self._seen.pop(name, None)

    @property
    def shown(self) -> dict[str, tuple[Array, float]]:
        """What is published now: name -> position, shape (3,), world frame [m], and confidence."""
        return dict(self._seen)

    def observe(self, robot: Truth) -> list[Percept]:
        """Return what is published now, in the robot's base frame."""
        rotation = rotation_matrix(robot.base_quaternion)
        return [
            Percept(name, robot.time, rotation.T @ (position - robot.base_position), confidence)
            for name, (position, confidence) in self._seen.items()
        ]
