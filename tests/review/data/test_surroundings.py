"""What a recording's tables tell of what stood around the robot and of what touched it."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from humanoid_bt.review.recording import Recording, open_recording
from humanoid_bt.session.run import run
from tests.review.direct import recorded_directly

SCENE = """
format: 1
name: room
objects:
  crate: {shape: box, size: [0.4, 0.3, 0.6], solid: true, position: [1.5, 0.3, 0.3]}
  ball: {shape: ball, size: [8 cm], position: [1.5, -0.3, 0.9]}
  wall: {shape: box, size: [0.1, 2, 1], solid: true, position: [-0.45, 0, 0.5]}
percepts: {target: {object: ball}}
"""
BACK = """
format: 1
name: back
root:
  emergency_stop:
    step_back: {distance: 40 cm}
"""


@pytest.fixture(scope="module")
def bumped(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """The robot backs into a wall that it does not see."""
    folder = tmp_path_factory.mktemp("bumped")
    for name, text in {"room.yaml": SCENE, "back.yaml": BACK}.items():
        (folder / name).write_text(text)
    file: Path = folder / "run.rrd"
    with recorded_directly():
        run(str(folder / "back.yaml"), scene=str(folder / "room.yaml"), duration=3.0, record=file, camera=False)
    return open_recording(file)


def test_obstacles_have_a_size_and_a_heading_and_other_percepts_none(bumped: Recording) -> None:
    seen = {row["name"]: row for row in bumped.percepts().to_pylist()}
    crate, target = seen["crate"], seen["target"]
    assert [crate[name] for name in ("length", "width", "height")] == pytest.approx([0.4, 0.3, 0.6])
    assert crate["heading"] == pytest.approx(0.0, abs=0.1)
    assert {target[name] for name in ("length", "width", "height", "heading")} == {None}


def test_contacts_have_the_force_that_was_felt_and_its_direction(bumped: Recording) -> None:
    felt = bumped.contacts().to_pylist()
    assert felt
    for row in felt:
        assert row["force"] == pytest.approx(math.hypot(row["x"], row["y"], row["z"]))
        assert row["force"] <= row["largest"] + 1e-9
    assert sum(row["x"] for row in felt) > 0  # the wall behind it pushes it ahead
    assert {row["group"] for row in felt} <= {"left_arm", "right_arm", "torso"}
    states = {tick.state.time: tick.state for tick in bumped.every_tick()}
    for row in felt:
        contact = states[row["time"]].contacts[row["group"]]
        assert (row["largest"], row["yields"]) == (contact.largest, contact.yields)
        assert [row["x"], row["y"], row["z"]] == pytest.approx(contact.force)
    assert len(felt) == sum(len(state.contacts) for state in states.values())
