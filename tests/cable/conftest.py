from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.cable.impairment import Impairment
from humanoid_bt.cable.lockstep import LockstepPlant
from humanoid_bt.cable.payloads import Hello
from humanoid_bt.cable.safe_state import SafeState
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime.served_simulation import ServedSimulation
from humanoid_bt.robot.model import RobotModel
from tests.cable.cabled import PERFECT

Loaded = tuple[RobotModel, np.ndarray, Scene]


@pytest.fixture(scope="session")
def loaded() -> Loaded:
    """The built-in humanoid, how it stands, and an empty floor."""
    workspace = Workspace(builtin_root())
    robot, start = load_robot(Path(workspace.find_robot("humanoid")))
    return robot, start, Scene(load_scene(workspace.find_scene("empty")), 0)


@pytest.fixture
def hello(loaded: Loaded) -> Hello:
    robot, _, scene = loaded
    return Hello("humanoid", tuple(robot.joint_names), scene.config.name, 0, scene.config.digest)


@pytest.fixture
def plant(loaded: Loaded, hello: Hello) -> Callable[..., LockstepPlant]:
    """Make a plant behind a simulated cable."""

    def made(
        impairment: Impairment = PERFECT,
        safe: SafeState = "hold",
        watchdog: float = 0.02,
        key: bytes | None = None,
        says: Hello = hello,
    ) -> LockstepPlant:
        served = ServedSimulation(*loaded, watchdog, safe)
        return LockstepPlant(served, says, impairment, key=key)

    return made
