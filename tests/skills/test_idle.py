"""The skill ``idle``, alone on the simulated robot."""

import math
from pathlib import Path

import numpy as np
import pytest
from py_trees.common import Status

from humanoid_bt import Gait, Rig
from humanoid_bt.cli import main


@pytest.mark.trials
def test_stands_where_it_is_and_looks_to_both_sides_ever_wider(rig: Rig) -> None:
    start = rig.state.stance.copy()
    result = rig.run("idle", timeout=9)
    assert result.status is Status.RUNNING
    assert np.linalg.norm(rig.state.stance[:2] - start[:2]) < 0.005
    assert all(state.gait is Gait.STAND for state in result.states)
    yaw = [math.atan2(state.gaze_direction[1], state.gaze_direction[0]) for state in result.states]
    first, second = max(yaw[:225]), -min(yaw[225:])
    assert 0.3 < first < second
    down = [-math.asin(state.gaze_direction[2]) for state in result.states]
    assert max(down) == pytest.approx(0.5, abs=0.05)
    assert 200 < down.index(max(down)) < 250  # ahead, when it looks near
    assert down[-1] < 0.25


def test_breathes(rig: Rig) -> None:
    result = rig.run("idle", look_around=False, breath=0.01, timeout=4)
    heights = [state.com[2] for state in result.states]
    assert max(heights) - min(heights) == pytest.approx(0.01, abs=0.004)


@pytest.mark.trials
def test_stands_up_again_when_halted(rig: Rig) -> None:
    height = rig.state.com[2]
    rig.run("idle", breath=0.02, timeout=2)
    assert rig.settle(1.5).com[2] == pytest.approx(height, abs=0.002)


def test_one_that_does_not_look_around_leaves_the_gaze_to_others(tmp_path: Path) -> None:
    (tmp_path / "trees").mkdir()
    tree = tmp_path / "trees" / "breathes.yaml"
    tree.write_text(
        "format: 1\nscene: ball_on_stand\nroot: {emergency_stop: {watchdog: {percept: target, max_age: 0.5 s, "
        "parallel: {success: 1, children: [{idle: {look_around: false}}, {look_at: {target: target}}]}}}}\n",
        encoding="utf-8",
    )
    assert main(["check", str(tree)]) == 0
