"""The trunk lunges where a step misses, within what the waist can, and gets upright again slowly."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.control.body.lunge import Lunge
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import RobotModel

DT = 0.01
NONE, ASIDE = np.zeros(2), np.array([0.0, 0.2])


@pytest.fixture
def lunge(robot: RobotModel) -> Lunge:
    return Lunge(robot, DT)


def go_on(lunge: Lunge, missed: Array, time: float, steps: bool = True) -> Array:
    """Return the leans of every period, shape (n, 2)."""
    leans = []
    for _ in range(round(time / DT)):
        lunge.update(missed, steps)
        leans.append(lunge.lean.copy())
    return np.array(leans)


def accelerations(leans: Array) -> Array:
    return np.linalg.norm(np.diff(leans, 2, axis=0), axis=1) / DT**2


def test_what_steps_reach_moves_no_trunk(lunge: Lunge) -> None:
    assert not go_on(lunge, np.array([0.02, -0.02]), 0.3).any()
    assert not lunge.active
    assert lunge.tilts(0.3) == (0.0, 0.0, 0.0, 0.0)


def test_it_leans_toward_where_the_robot_falls_as_far_as_it_may(lunge: Lunge, robot: RobotModel) -> None:
    missed = np.array([0.16, 0.12])
    leans = go_on(lunge, missed, 0.6)
    np.testing.assert_allclose(leans[-1], robot.config.gait.lunge * missed / 0.2, atol=1e-3)
    np.testing.assert_allclose(leans[:, 1], 0.75 * leans[:, 0], atol=1e-9)
    assert np.linalg.norm(leans, axis=1).max() < robot.config.gait.lunge + 0.03
    assert leans[round(0.15 / DT)].sum() > 0.2  # quickly: a step takes no longer
    assert accelerations(leans).max() < 21


def test_it_leans_less_where_less_is_missed(lunge: Lunge, robot: RobotModel) -> None:
    assert go_on(lunge, np.array([0.04, 0.0]), 0.6)[-1, 0] == pytest.approx(0.5 * robot.config.gait.lunge, abs=1e-3)


def test_it_gets_upright_slowly_once_steps_have_reached_far_enough_for_a_while(lunge: Lunge) -> None:
    leaned = go_on(lunge, ASIDE, 0.6)[-1]
    stays = go_on(lunge, NONE, 0.2)
    np.testing.assert_allclose(stays, np.tile(leaned, (len(stays), 1)), atol=0.01)
    back = go_on(lunge, NONE, 2.0)
    assert accelerations(back).max() < 5
    assert lunge.active is False
    assert not back[-1].any()


def test_a_robot_that_steps_no_more_gets_upright_at_once(lunge: Lunge) -> None:
    leaned = go_on(lunge, ASIDE, 0.6)[-1]
    assert go_on(lunge, NONE, 0.2, steps=False)[-1, 1] < leaned[1] - 0.02


def test_pelvis_and_trunk_turn_about_the_axes_of_the_heading(lunge: Lunge) -> None:
    go_on(lunge, ASIDE, 0.6)  # to the left of a robot that faces along x: it rolls to its left
    pelvis_roll, pelvis_pitch, roll, pitch = lunge.tilts(0.0)
    assert roll == pytest.approx(-0.6, abs=0.01)
    assert pelvis_roll == pytest.approx(0.2 * roll, rel=0.01)
    assert abs(pitch) + abs(pelvis_pitch) < 1e-9
    ahead = lunge.tilts(math.pi / 2)
    np.testing.assert_allclose(ahead, (pelvis_pitch, -pelvis_roll, pitch, -roll), atol=1e-3)


def test_it_does_not_matter_which_way_round_the_waist_turns(lunge: Lunge, other_frames: RobotModel) -> None:
    other = Lunge(other_frames, DT)
    for missed in (ASIDE, np.array([0.2, 0.0]), np.array([-0.2, 0.0])):
        assert np.array_equal(go_on(lunge, missed, 0.3), go_on(other, missed, 0.3))
        assert lunge.tilts(0.0) == other.tilts(0.0)


def test_a_waist_that_does_not_roll_leaves_the_trunk_as_the_pelvis_is(robot: RobotModel) -> None:
    rigid = RobotModel(replace(robot.config, torso=robot.config.base))
    lunge = Lunge(rigid, DT)
    go_on(lunge, ASIDE, 0.6)
    pelvis_roll, _, roll, _ = lunge.tilts(0.0)
    assert roll == pelvis_roll < 0


def test_a_robot_that_is_not_to_lunge_does_not(robot: RobotModel) -> None:
    upright = RobotModel(replace(robot.config, gait=replace(robot.config.gait, lunge=0.0)))
    lunge = Lunge(upright, DT)
    assert not go_on(lunge, ASIDE, 0.3).any()
    assert not lunge.active


def test_it_begins_anew_after_it_was_cut_short(lunge: Lunge, robot: RobotModel) -> None:
    go_on(lunge, ASIDE, 0.1)
    lunge.reset()
    assert not lunge.active
    np.testing.assert_array_equal(go_on(lunge, ASIDE, 0.1), go_on(Lunge(robot, DT), ASIDE, 0.1))
