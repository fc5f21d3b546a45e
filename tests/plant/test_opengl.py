"""Pictures where there is no EGL, and what a wrong choice of OpenGL leads to."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from ctypes.util import find_library
from pathlib import Path

import mujoco
import numpy as np
import pytest

from humanoid_bt.plant.camera_client import CameraProcess
from humanoid_bt.plant.opengl import CHOICE
from humanoid_bt.plant.rendering import Setup, View, first_shot

MODEL = "<mujoco><worldbody><body name='head'/><geom type='box' size='.1 1 1' pos='2 0 1'/></worldbody></mujoco>"
NO_EGL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/none"}  # as on a machine that has no driver for it


@pytest.fixture
def camera(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., CameraProcess]]:
    opened: list[CameraProcess] = []
    monkeypatch.delenv(CHOICE, raising=False)

    def make(**environment: str) -> CameraProcess:
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        model = mujoco.MjModel.from_xml_string(MODEL)
        opened.append(CameraProcess(Setup(model, View("head", 1.0, 1.0), depth=True), float("inf"), 10.0))
        return opened[-1]

    yield make
    for one in opened:
        one.end()


@pytest.mark.skipif(find_library("OSMesa") is None, reason="there is no OSMesa on this machine")
def test_without_egl_pictures_come_from_osmesa(camera: Callable[..., CameraProcess]) -> None:
    process = camera(**NO_EGL, PYOPENGL_PLATFORM="egl")  # which MuJoCo would not go on with
    assert not process.open()
    assert process.process is not None
    assert "OSMesa" in Path(f"/proc/{process.process.pid}/maps").read_text()
    _, depth = process.take(first_shot())
    middle = depth.shape[0] // 2, depth.shape[1] // 2
    np.testing.assert_allclose(depth[middle], 1.9, atol=1e-3)  # to the box


@pytest.mark.skipif(find_library("EGL") is None, reason="there is no EGL on this machine, which says other things")
def test_without_any_the_first_reason_is_told(
    camera: Callable[..., CameraProcess], monkeypatch: pytest.MonkeyPatch
) -> None:
    process = camera(**NO_EGL)
    monkeypatch.setattr("humanoid_bt.plant.camera_client._OTHERS", ())
    assert "there is no OpenGL to render with (Cannot initialize a EGL device display" in process.open()


def test_a_choice_that_renders_nothing_is_told(camera: Callable[..., CameraProcess]) -> None:
    why = camera(**{CHOICE: "glx"}).open()  # which only a program with a window has
    assert "there is no OpenGL to render with" in why
    assert "MUJOCO_GL is 'glx': unset it" in why


def test_a_choice_that_mujoco_does_not_load_with_is_told() -> None:
    command = [sys.executable, "-m", "humanoid_bt", "sources"]
    environment = {**os.environ, CHOICE: "osmessa"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    first, second = done.stderr.splitlines()
    assert first.startswith("error: MuJoCo does not load with MUJOCO_GL=osmessa: ")
    assert "unset MUJOCO_GL" in second


@pytest.mark.parametrize(
    ("horizontal", "vertical", "size"),
    [(1.745, 1.396, (320, 225)), (1.745, 0.001, (320, 32)), (0.001, 1.396, (320, 3200)), (0.001, 0.001, (320, 320))],
)
def test_a_picture_shows_all_of_a_view_however_narrow(
    horizontal: float, vertical: float, size: tuple[int, int]
) -> None:
    view = View("", horizontal, vertical)
    assert view.size == size
    shown = [2 * math.atan(pixels / 2 / view.focal) for pixels in view.size]
    assert shown[0] >= 0.99 * horizontal
    assert shown[1] >= 0.99 * vertical
