"""Trials: one run of a tree each, and all that tells them apart."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

SET, CONDITION, PUSH = "set", "condition", "push"
"""What stands before the name of a parameter, a condition, and a number of a push, in a column of the results."""


@dataclass(frozen=True)
class Trial:
    """One run of a tree.

    Attributes:
        number: its place in the campaign, from 0.
        tree: name or file of the tree.
        robot, scene: names or files.
        seed: of everything random.
        given: what it is given beside, by column: ``set.stop_distance``, ``condition.friction``, ``push.force``.
        duration: longest simulated time [s]; None for what a run has.
        dry: whether it runs without physics.
    """

    number: int
    tree: str
    robot: str
    scene: str
    seed: int
    given: Mapping[str, Any] = field(default_factory=dict)
    duration: float | None = None
    dry: bool = False

    @cached_property
    def id(self) -> str:
        """What it is called: the same for the same trial, whatever others a campaign has."""
        what = [self.tree, self.robot, self.scene, self.seed, dict(self.given), self.duration, self.dry]
        text = json.dumps(what, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:10]

    def part(self, of: str) -> dict[str, Any]:
        """Return what it is given of one sort, as :data:`SET`, by name."""
        return {name.removeprefix(f"{of}."): value for name, value in self.given.items() if name.startswith(f"{of}.")}


@dataclass(frozen=True)
class Task:
    """A trial to be run.

    Attributes:
        trial: it.
        recording: file to which it is recorded, and which is explained then; "" for none.
    """

    trial: Trial
    recording: str = ""
