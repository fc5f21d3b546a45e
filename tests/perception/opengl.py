"""Pictures for tests, where the machine can render."""

from __future__ import annotations

import functools

import mujoco
import pytest

from humanoid_bt.plant.camera_client import CameraProcess
from humanoid_bt.plant.rendering import Setup, View


@functools.cache
def why_none() -> str:
    """Return why there are no pictures on this machine, "" if there are."""
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><body name='head'/></worldbody></mujoco>")
    camera = CameraProcess(Setup(model, View("head", 1.0, 1.0)), float("inf"))
    try:
        return camera.open()
    finally:
        camera.end()


@pytest.fixture
def opengl() -> None:
    """Skip a test where there are no pictures."""
    if why := why_none():
        pytest.skip(why)
