"""A supervisor that is run cycle by cycle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from humanoid_bt.control.supervisor import Supervisor
from humanoid_bt.core.messages import (
    Command,
    Estimate,
    HandTarget,
    Mode,
    Pause,
    Target,
)
from humanoid_bt.robot.arms import Arms
from humanoid_bt.robot.config import FallConfig

HEIGHT = 0.7
UPRIGHT = Estimate(
    time=0.0,
    qpos=np.array([0, 0, HEIGHT, 1, 0, 0, 0, 0.1, -0.1]),
    qvel=np.zeros(8),
    joint_torque=np.zeros(2),
    foot_force=np.zeros(2),
)
ARMS: Arms = {"left": {"left_elbow": (-2.28, -0.02)}, "right": {"right_elbow": (-2.28, -0.02)}}
HAND: Mapping[str, Target] = {"left_hand": HandTarget(np.array([0.4, 0.1, 0.9]))}
SOURCES = {"left_hand": "root/reach"}


def lying(pitch: float = 1.5, height: float = HEIGHT) -> Estimate:
    qpos = UPRIGHT.qpos.copy()
    qpos[2:7] = [height, math.cos(pitch / 2), 0, math.sin(pitch / 2), 0]
    return replace(UPRIGHT, qpos=qpos)


def on_its_side(roll: float) -> Estimate:
    qpos = UPRIGHT.qpos.copy()
    qpos[3:7] = [math.cos(roll / 2), math.sin(roll / 2), 0, 0]
    return replace(UPRIGHT, qpos=qpos)


class Run:
    """A supervisor and its cycles."""

    def __init__(self) -> None:
        self.supervisor = Supervisor(FallConfig(), ARMS)
        self.supervisor.reset_run(HEIGHT)
        self.cycle = -1
        self.sequence = 0
        self.go()

    @property
    def mode(self) -> Mode:
        return self.supervisor.mode

    def go(self, cycles: int = 1, estimate: Estimate = UPRIGHT, fault: str = "", alive: bool = False) -> None:
        """Pass some cycles; ``alive``: decision sends a command in each of them."""
        for _ in range(cycles):
            self.cycle += 1
            self.supervisor.check(self.cycle, estimate, fault)
            if alive:
                self.send()

    def send(
        self, targets: Any = HAND, sequence: int | None = None, age: float = 0.0, pause: Pause | None = None
    ) -> bool:
        if sequence is None:
            self.sequence += 1
            sequence = self.sequence
        return self.supervisor.submit(Command(sequence, self.cycle * 1e-3 - age, targets, SOURCES, pause))
