"""The skill ``look_at``, alone on the simulated robot."""

import math

import numpy as np
import pytest

from humanoid_bt import Gait, Rig


def off_target(rig: Rig, target: tuple[float, ...]) -> float:
    """Return the angle between the view and the direction of the target [rad]."""
    way = np.array(target) - rig.state.gaze_position
    return math.acos(float(rig.state.gaze_direction @ way / np.linalg.norm(way)))


@pytest.mark.parametrize("target", [(1.0, 0.0, 0.9), (1.0, 1.5, 1.5), (-0.3, -1.0, 0.8)])
def test_brings_the_target_into_the_middle_of_the_view(rig: Rig, target: tuple[float, ...]) -> None:
    result = rig.run("look_at", target=target)
    assert result.succeeded, result.feedback
    assert off_target(rig, target) < 0.15
    assert all(state.gait is Gait.STAND for state in result.states)


def test_keeps_it_there_for_as_long_as_it_is_told(rig: Rig) -> None:
    result = rig.run("look_at", target=(2.0, 0.0, 1.2), hold=1.5)
    assert result.succeeded, result.feedback
    assert result.time == pytest.approx(1.5, abs=0.05)


def test_counts_anew_when_the_target_moves_away(rig: Rig) -> None:
    rig.at(0.8, lambda: rig.see("target", (1.0, -1.0, 1.2)))
    result = rig.run("look_at", target=(2.0, 0.0, 1.2), hold=1.0)
    assert result.succeeded, result.feedback
    assert result.time > 1.8
    assert off_target(rig, (1.0, -1.0, 1.2)) < 0.15


def test_says_how_near_it_came_when_the_target_is_out_of_view(rig: Rig) -> None:
    result = rig.run("look_at", target=(-1.0, 0.2, 1.2), patience=1.0)
    assert result.failed
    assert "comes no nearer to target than" in result.feedback


def test_looks_ahead_again_when_halted(rig: Rig) -> None:
    rig.run("look_at", target=(0.5, 1.0, 0.9), timeout=1.0)
    assert rig.state.gaze_direction[1] > 0.5
    assert rig.settle(1.5).gaze_direction[0] == pytest.approx(1.0, abs=0.01)


def test_fails_when_the_target_was_never_seen(rig: Rig) -> None:
    result = rig.run("look_at", target="nothing")
    assert result.failed
    assert "'nothing' was never seen: perception offers no such percept" in result.feedback
