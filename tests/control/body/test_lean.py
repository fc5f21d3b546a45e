from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from humanoid_bt.control.body.lean import LeanReference
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import RobotModel

DT = 0.005
EYES, BASE = np.array([0.06, 0.0, 1.2]), np.array([0.0, 0.0, 0.7])


@pytest.fixture(scope="module")
def neckless(robot: RobotModel) -> RobotModel:
    return RobotModel(dataclasses.replace(robot.config, neck=None))


@pytest.fixture(scope="module")
def rigid(robot: RobotModel) -> RobotModel:
    """A robot with neither a neck nor a waist."""
    return RobotModel(dataclasses.replace(robot.config, neck=None, torso=robot.config.base))


def below(angle: float, direction: float = 0.0) -> Array:
    """Return a point that far below the eyes' horizon [rad], in a direction from straight ahead [rad]."""
    return EYES + np.array([math.cos(direction), math.sin(direction), -math.tan(angle)])


def lean(
    robot: RobotModel, point: Array | None, before: LeanReference | None = None, heading: float = 0.0
) -> LeanReference:
    """Let the trunk come to rest."""
    reference = before or LeanReference(robot, DT)
    for _ in range(1000):
        reference.update(point, False, EYES, BASE, heading)
    return reference


def test_it_leans_by_what_is_missing(neckless: RobotModel) -> None:
    unaided = neckless.config.whole_body.gaze_below
    assert lean(neckless, below(unaided - 0.01)).torso == 0
    assert lean(neckless, below(unaided + 0.2)).torso == pytest.approx(0.2)
    assert lean(neckless, below(1.5)).torso == pytest.approx(neckless.config.whole_body.gaze_lean)


def test_it_stands_upright_while_the_neck_suffices(robot: RobotModel) -> None:
    assert lean(robot, below(1.2)).torso == 0
    assert lean(robot, below(1.5)).torso > 0


def test_it_does_not_lean_for_what_is_aside_or_behind(neckless: RobotModel) -> None:
    assert lean(neckless, below(1.0, math.pi / 2)).torso == pytest.approx(0, abs=0.05)
    for angle in (-0.5, 0.0, 1.0):
        assert lean(neckless, below(angle, math.pi)).torso == 0
    assert lean(neckless, below(1.0, math.pi / 2), heading=math.pi / 2).torso > 0.1


def test_the_waist_leans_first_then_the_pelvis(neckless: RobotModel, rigid: RobotModel) -> None:
    assert lean(neckless, below(1.4)).base == 0
    leaning = lean(rigid, below(0.8))
    assert leaning.base == leaning.torso > 0.2


def test_it_does_not_matter_which_way_round_joints_turn(robot: RobotModel, other_frames: RobotModel) -> None:
    one, other = (lean(of, below(1.5)) for of in (robot, other_frames))
    assert (one.torso, one.base) == (other.torso, other.base)


def test_the_body_sinks_when_leaning_is_not_enough(neckless: RobotModel) -> None:
    whole_body = neckless.config.whole_body
    assert lean(neckless, below(whole_body.gaze_below + whole_body.gaze_lean)).crouch == 0
    assert 0 < lean(neckless, below(1.5)).crouch <= whole_body.gaze_crouch


def test_the_pelvis_stays_far_from_what_counts_as_a_fall(rigid: RobotModel) -> None:
    assert lean(rigid, below(1.5)).base < rigid.config.fall.tilt - 0.25


def test_it_goes_slowly_stays_in_hold_and_comes_back(neckless: RobotModel) -> None:
    reference = LeanReference(neckless, DT)
    reference.update(below(1.4), False, EYES, BASE, 0.0)
    assert 0 < reference.torso < 0.5 * DT
    lean(neckless, below(1.5), reference)
    assert reference.crouch > 0
    reference.reset()
    assert reference.torso == reference.crouch == 0
    reference.update(below(1.5), False, EYES, BASE, 0.0)
    assert 0 < reference.crouch < 0.06 * DT
    there = lean(neckless, below(1.0), reference).torso
    reference.update(None, True, EYES, BASE, 0.0)
    assert reference.torso == there
    assert lean(neckless, None, reference).torso == 0
