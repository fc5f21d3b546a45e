"""Percepts that a test dictates."""

from __future__ import annotations

from typing import Any

import numpy as np

from humanoid_bt.core.geometry import heading_of, rotation_matrix
from humanoid_bt.core.messages import Array, Percept, State, Truth
from humanoid_bt.perception.interface import Perception


class ScriptedPerception(Perception):
    """Percepts that a test dictates: exact positions, at 10 Hz, from any place in the world."""

    def __init__(self) -> None:
        self._seen: dict[str, tuple[Array, float]] = {}
        self._sizes: dict[str, Array] = {}

    def see(self, name: str, position: Any, confidence: float, size: Any = None) -> None:
        """Publish a thing at a position, shape (3,), world frame [m], from now on.

        Args:
            name, position, confidence: of the percept.
            size: of a solid thing, shape (3,): length, width, height [m].
        """
        self._seen[name] = (np.array(position, dtype=float), confidence)
        self._sizes.pop(name, None)
        if size is not None:
            self._sizes[name] = np.array(size, dtype=float)
            self._sizes[name].setflags(write=False)

    def lose(self, name: str) -> None:
        """Publish nothing of a thing from now on; its last percept grows old."""
        self._seen.pop(name, None)

    @property
    def shown(self) -> dict[str, tuple[Array, float, Array | None]]:
        """What is published now: name -> position, shape (3,), world frame [m], confidence, and size."""
        return {name: (*seen, self._sizes.get(name)) for name, seen in self._seen.items()}

    def observe(self, robot: Truth, _state: State | None = None) -> list[Percept]:
        """Return what is published now, in the robot's base frame."""
        rotation = rotation_matrix(robot.base_quaternion)
        heading = -heading_of(rotation)  # of the world, as the robot sees it
        return [
            Percept(
                name,
                robot.time,
                rotation.T @ (position - robot.base_position),
                confidence,
                self._sizes.get(name),
                heading,
            )
            for name, (position, confidence) in self._seen.items()
        ]
