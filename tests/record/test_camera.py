"""The head camera's pictures: what is on them, when there are some, and why there are none."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from PIL import Image

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array
from humanoid_bt.plant.rendering import Setup
from humanoid_bt.record import camera, photographer
from humanoid_bt.record.recorder import Recorder
from tests.record.helpers import make_state, rows

Maker = Callable[..., Recorder]
BALL = np.array([1.5, 0.0, 1.2])


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.rrd"


@pytest.fixture
def recorded(record: Maker) -> Maker:
    """Return a maker of recorders that insist on pictures; skips where there is no OpenGL."""
    try:
        record(pictures=True).close()
    except UserError as error:
        pytest.skip(str(error))
    return lambda: record(pictures=True)


def pictures(file: Path) -> list[tuple[float, Array]]:
    """Return the pictures, each as height x width x 3."""
    blobs = rows(file, "/camera", "EncodedImage:blob")
    return [(time, np.array(Image.open(io.BytesIO(bytes(blob[0]))), dtype=float)) for time, blob in blobs]


def why(file: Path) -> list[str]:
    return [label for _, (label,) in rows(file, "/camera/why", "Points2D:labels")]


def sample(recorder: Recorder, time: float, ball: Array = BALL, **more: Any) -> None:
    state = replace(make_state(time), gaze_position=np.array([0.2, 0.0, 1.2]))
    recorder.sample(state, {}, {"ball": ball}, **more)


def test_five_pictures_a_second_show_what_is_ahead(recorded: Maker, file: Path) -> None:
    with recorded() as recorder:
        for tick in range(50):
            sample(recorder, tick * 0.02)
    taken = pictures(file)
    assert [time for time, _ in taken] == pytest.approx([0, 0.2, 0.4, 0.6, 0.8])
    assert [time for time, _ in rows(file, "/camera", "Transform3D:translation")] == [time for time, _ in taken]
    _, picture = taken[-1]
    height, width, _ = picture.shape
    assert width / height == pytest.approx(np.tan(0.85) / np.tan(0.7), rel=0.01)
    assert why(file) == []


def test_a_thing_is_where_it_is_and_a_hidden_one_is_not_there(recorded: Maker, file: Path) -> None:
    left, right = BALL + np.array([0.0, 0.6, 0.0]), BALL - np.array([0.0, 0.6, 0.0])
    with recorded() as recorder:
        sample(recorder, 0.0, left)
        sample(recorder, 0.2, right)
        sample(recorder, 0.4, right, hidden={"ball"})
        sample(recorder, 0.6, BALL + np.array([0.0, 0.0, 0.5]))
    at_left, at_right, none, above = (picture for _, picture in pictures(file))

    def middle(picture: Array) -> Array:
        """Return row and column of what differs from the empty scene, as shares of the picture."""
        changed = np.argwhere(np.abs(picture - none).max(axis=2) > 40)
        return np.asarray(changed.mean(axis=0) / none.shape[:2])

    share = 0.5 * 0.6 / 1.3 / np.tan(0.85)  # 1.3 m ahead, 0.6 m aside
    assert middle(at_left) == pytest.approx([0.5, 0.5 - share], abs=0.02)
    assert middle(at_right) == pytest.approx([0.5, 0.5 + share], abs=0.02)
    assert middle(above)[0] == pytest.approx(0.5 - 0.5 * 0.5 / 1.3 / np.tan(0.7), abs=0.02)


def test_without_opengl_there_is_a_reason_and_the_run_goes_on(
    record: Maker, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "none of the known ones")
    monkeypatch.setattr(camera, "_cores", lambda: 2)
    recorder = record(pictures="auto")
    recorder._camera._photographer.wait_until_ready()
    with recorder:
        for tick in range(60):
            sample(recorder, tick * 0.02)
    assert pictures(file) == []
    assert "there is no OpenGL to render with (" in why(file)[0]
    ((_, (event,)),) = rows(file, "/events", "TextLog:text")
    assert "no picture of the head camera: there is no OpenGL" in event
    assert len(rows(file, "/camera", "Transform3D:translation")) == 6  # percepts are drawn all the same
    with pytest.raises(UserError, match="there is no OpenGL"):
        record(pictures=True)


@pytest.mark.parametrize("busy", [1, 2])
def test_no_core_is_taken_from_the_run(record: Maker, file: Path, monkeypatch: pytest.MonkeyPatch, busy: int) -> None:
    monkeypatch.setattr(camera, "_cores", lambda: busy)
    with record(pictures="auto", busy_cores=busy) as recorder:
        sample(recorder, 0.0)
    assert why(file) == ["no picture: the run leaves no core for it"]


def test_nothing_is_said_of_pictures_that_nobody_wants(record: Maker, file: Path) -> None:
    with record(pictures=False) as recorder:
        sample(recorder, 0.0)
    assert rows(file, "/events", "TextLog:text") == []
    assert why(file) == ["no picture: it is switched off"]


@pytest.mark.trials
def test_pictures_that_take_too_long_are_left_to_who_insists(
    recorded: Maker, record: Maker, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(camera, "_SLOWEST", 1e-6)
    monkeypatch.setattr(camera, "_cores", lambda: 2)
    recorder = record(pictures="auto")
    recorder._camera._photographer.wait_until_ready()
    with recorder:
        sample(recorder, 0.0)
    assert "ms of the processor here, more than 0 ms" in why(file)[0]


def test_its_process_ends_with_the_recording(recorded: Maker) -> None:
    recorder = recorded()
    process = recorder._camera._photographer._camera.process
    recorder.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process.pid, 0)


def test_a_process_that_dies_is_a_reason_too(recorded: Maker, file: Path) -> None:
    recorder = recorded()
    sample(recorder, 0.0)
    photographer = recorder._camera._photographer
    photographer._camera.process.kill()
    photographer._camera.process.wait()
    photographer._thread.join()
    sample(recorder, 0.2)
    recorder.close()
    assert why(file) == ["no picture: its process ended"]


@pytest.mark.parametrize(("slowest", "patience"), [(0.05, 5.0), (math.inf, 60.0)], ids=["auto", "on"])
def test_the_end_of_a_run_of_ten_hours_waits_no_longer(
    monkeypatch: pytest.MonkeyPatch, slowest: float, patience: float
) -> None:
    process = SimpleNamespace(open=lambda: "there is none", end=lambda: None, over=False)
    monkeypatch.setattr(photographer, "CameraProcess", lambda *_: process)
    waiting = photographer.Photographer(cast("Setup", None), slowest)
    waiting._began -= 36_000
    assert waiting.patience == patience
    waiting.finish()


def test_a_run_that_is_over_at_once_does_not_wait_for_pictures(
    record: Maker, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(camera, "_cores", lambda: 2)
    with record(pictures="auto") as recorder:
        sample(recorder, 0.0)
    assert pictures(file) == []
    assert why(file) == ["no picture: the run was over before the first one was there"]
