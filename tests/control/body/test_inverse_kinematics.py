from __future__ import annotations

import math
from typing import Any

import daqp
import numpy as np
import pytest

from humanoid_bt.control.body.body_task import BodyTargets
from humanoid_bt.control.body.inverse_kinematics import InverseKinematics
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel, palm_site, sole_site
from tests.control.body.pose import Pose

DT = 0.005


@pytest.fixture
def kinematics(robot: RobotModel, standing: Array) -> InverseKinematics:
    kinematics = InverseKinematics(robot, DT)
    kinematics.reset(standing)
    return kinematics


def configuration(kinematics: InverseKinematics) -> Array:
    return np.concatenate([kinematics.base_pose, kinematics.joints])


def targets(robot: RobotModel, standing: Array, **given: Any) -> BodyTargets:
    """Stand as in the start posture, except for what is given."""
    half = robot.config.gait.stance_width / 2
    stand: dict[str, Any] = {
        "com": Pose(robot, standing).com,
        "soles": {"left": np.array([0, half, 0]), "right": np.array([0, -half, 0])},
        "sole_footings": dict.fromkeys(SIDES, np.zeros(3)),
        "sole_corrections": {side: np.zeros(6) for side in SIDES},
        "heading": 0.0,
        "torso_yaw": 0.0,
        "lean": (0.0, 0.0),
        "gaze": (0.0, 0.0),
        "hands": {},
        "reaching": 0.0,
        "posture": standing[BASE_COORDINATES:].copy(),
    }
    return BodyTargets(**{**stand, **given})


def no_solution(hessian: Array, *_: Array) -> tuple[Array, float, int, dict[str, Array]]:
    return np.zeros(len(hessian)), 0.0, -1, {}


def not_finite(hessian: Array, *_: Array) -> tuple[Array, float, int, dict[str, Array]]:
    return np.full(len(hessian), np.nan), 0.0, 1, {}


def test_the_centre_of_mass_moves_and_the_feet_stay(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics
) -> None:
    goal = Pose(robot, standing).com + np.array([0.02, 0.04, -0.03])
    wanted = targets(robot, standing, com=goal)
    for _ in range(200):
        assert kinematics.step(wanted)
    pose = Pose(robot, configuration(kinematics))
    np.testing.assert_allclose(pose.com[:2], goal[:2], atol=1e-3)
    assert pose.com[2] == pytest.approx(goal[2], abs=0.01)  # the home posture pulls a little against the height
    for side in SIDES:
        np.testing.assert_allclose(pose.site(sole_site(side)), [*wanted.soles[side][:2], 0], atol=1e-3)
        np.testing.assert_allclose(pose.rotation(sole_site(side)), np.eye(3), atol=5e-3)


@pytest.mark.parametrize("place", [(0.0, 0.4), (-0.4, 0.1), (0.5, 0.1)], ids=["aside", "behind", "ahead"])
def test_a_foot_in_the_air_is_brought_as_far_as_its_leg_reaches_and_not_the_body_with_it(
    robot: RobotModel, standing: Array, place: tuple[float, float]
) -> None:
    """A robot that steps far after a push would be planned where it is not, and fall."""
    half = robot.config.gait.stance_width / 2
    soles = {"left": np.array([*place, 0.0]), "right": np.array([0, -half, 0])}

    def off(swings: Side | None) -> float:
        kinematics = InverseKinematics(robot, DT)
        kinematics.reset(standing)
        com = Pose(robot, standing).com - np.array([0, half, 0])
        for _ in range(100):
            assert kinematics.step(targets(robot, standing, com=com, soles=soles, swings=swings))
        return math.hypot(*kinematics.com_error[:2])

    assert off("left") < 0.75 * off(None)


def torso_lean(robot: RobotModel, kinematics: InverseKinematics) -> float:
    """Return how far the torso of a robot that looks along x leans ahead [rad]."""
    torso = Pose(robot, configuration(kinematics)).data.body(robot.config.torso).xmat.reshape(3, 3)
    return float(np.arctan2(torso[0, 2], torso[2, 2]))


def test_a_hand_reaches_its_target_with_the_feet_on_the_ground(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics
) -> None:
    goal = np.array([0.35, 0.2, 0.9])
    wanted = targets(robot, standing, hands={"left": goal}, reaching=1.0)
    for _ in range(300):
        kinematics.step(wanted)
    pose = Pose(robot, configuration(kinematics))
    np.testing.assert_allclose(pose.site(palm_site("left")), goal, atol=2e-3)
    np.testing.assert_allclose(kinematics.palm("left"), goal, atol=2e-3)
    np.testing.assert_allclose(pose.site(sole_site("left")), [*wanted.soles["left"][:2], 0], atol=1e-3)


@pytest.mark.parametrize("lean", [(0.0, 0.4), (0.4, 0.4)])
def test_the_trunk_leans_over_feet_that_stay(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics, lean: tuple[float, float]
) -> None:
    wanted = targets(robot, standing, lean=lean, torso_yaw=0.5)
    for _ in range(400):
        kinematics.step(wanted)
    pose = Pose(robot, configuration(kinematics))
    base, torso = (pose.data.body(name).xmat.reshape(3, 3) for name in (robot.config.base, robot.config.torso))
    assert np.arccos(base[2, 2]) == pytest.approx(lean[0], abs=0.08)
    assert np.arccos(torso[2, 2]) == pytest.approx(0.4, abs=0.08)
    assert -torso[2, 0] == pytest.approx(np.sin(0.4) * np.cos(0.5), abs=0.08)  # ahead, not where the torso faces
    np.testing.assert_allclose(pose.com[:2], wanted.com[:2], atol=2e-3)
    np.testing.assert_allclose(pose.site(sole_site("left")), [*wanted.soles["left"][:2], 0], atol=1e-3)


def test_a_torso_that_a_hand_bends_is_not_held_for_eyes_that_need_less(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics
) -> None:
    """It came up then, the eyes needed nothing, and it went down again, many times a second."""
    reaching = {"hands": {"left": np.array([0.5, 0.1, 0.5])}, "reaching": 1.0}
    for _ in range(300):
        kinematics.step(targets(robot, standing, **reaching))
    before = torso_lean(robot, kinematics)
    assert before > 0.3
    for _ in range(20):
        kinematics.step(targets(robot, standing, **reaching, lean=(0.0, 0.05)))
        assert torso_lean(robot, kinematics) > before - 0.01


def test_a_hand_does_not_keep_the_torso_from_what_the_eyes_need(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics
) -> None:
    high = {"hands": {"left": np.array([0.2, 0.3, 1.2])}, "reaching": 1.0}
    for _ in range(400):
        kinematics.step(targets(robot, standing, **high, lean=(0.0, 0.4)))
    assert torso_lean(robot, kinematics) == pytest.approx(0.4, abs=0.1)


@pytest.mark.parametrize("goal", [[2.0, 0, 2], [-2.0, 1, 0.2], [0, -2.0, 3], [0, 0, 0.3]])
def test_soft_limits_hold_whatever_is_asked(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics, goal: list[float]
) -> None:
    wanted = targets(robot, standing, hands={side: np.array(goal) for side in SIDES}, reaching=1.0, gaze=(2.0, 0.8))
    for _ in range(250):
        kinematics.step(wanted)
        assert (kinematics.joints >= robot.lower - 1e-6).all()
        assert (kinematics.joints <= robot.upper + 1e-6).all()


def test_a_joint_comes_to_rest_at_its_limit(robot: RobotModel, standing: Array, kinematics: InverseKinematics) -> None:
    """A knee that is stretched all at once is bent by the next plan, and stretched again: the robot shakes."""
    wanted = targets(robot, standing, com=Pose(robot, standing).com + np.array([0.0, 0.0, 0.2]))
    knees = [robot.joint(f"{side}_knee") for side in SIDES]

    def room() -> Array:
        return np.minimum(kinematics.joints - robot.lower, robot.upper - kinematics.joints)[knees]

    rooms = [room()]
    for _ in range(200):
        kinematics.step(wanted)
        rooms.append(room())
    before, after = np.array(rooms[:-1]), np.array(rooms[1:])
    assert before.max() > 0.3 and after[-1].max() < 0.1  # they were bent, and are stretched
    assert np.abs(after - before)[-50:].max() < 1e-3  # and stay so
    assert (after >= (1 - DT / 0.05) * before - 1e-6).all()


@pytest.mark.parametrize("solves", [True, False])
def test_the_base_comes_to_rest_above_its_limit_whatever_a_hand_asks(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics, monkeypatch: pytest.MonkeyPatch, solves: bool
) -> None:
    lowest = kinematics.lowest = 0.8 * standing[2]
    wanted = targets(robot, standing, hands={"left": np.array([0.4, 0.2, 0.0])}, reaching=1.0)
    if not solves:
        monkeypatch.setattr(daqp, "solve", no_solution)
    rooms = [standing[2] - lowest]
    for _ in range(300):
        assert kinematics.step(wanted) is solves
        rooms.append(kinematics.base_pose[2] - lowest)
        assert rooms[-1] >= (1 - DT / 0.1) * rooms[-2] - 1e-6
    assert rooms[-1] < 0.02  # it went there


def test_a_base_below_its_limit_may_stay(robot: RobotModel, standing: Array, kinematics: InverseKinematics) -> None:
    kinematics.lowest = standing[2] + 0.1
    for _ in range(20):
        assert kinematics.step(targets(robot, standing))
    assert kinematics.base_pose[2] == pytest.approx(standing[2], abs=5e-3)


@pytest.mark.parametrize("failure", [no_solution, not_finite])
def test_without_a_solution_it_goes_on_without_limits_and_says_so(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics, monkeypatch: pytest.MonkeyPatch, failure: Any
) -> None:
    wanted = targets(robot, standing, com=Pose(robot, standing).com + np.array([0.0, 0.02, 0.0]))
    monkeypatch.setattr(daqp, "solve", failure)
    for _ in range(20):
        assert not kinematics.step(wanted)
        assert not kinematics.solved
    after = Pose(robot, configuration(kinematics))
    np.testing.assert_allclose(after.com[:2], wanted.com[:2], atol=2e-3)
    for side in SIDES:
        np.testing.assert_allclose(after.site(sole_site(side))[:2], wanted.soles[side][:2], atol=2e-3)
    monkeypatch.undo()
    assert kinematics.step(wanted)
    assert kinematics.solved


def test_without_a_solution_nothing_is_faster_than_its_limit(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is held back by a limit leaves more to the others: the feet stay where they are."""
    monkeypatch.setattr(daqp, "solve", no_solution)
    far = targets(robot, standing, com=Pose(robot, standing).com + np.array([0.0, 0.0, -0.2]))
    kinematics.ease(0.2)
    kinematics.step(far)
    speeds = np.abs(kinematics.velocity)
    assert speeds[2] == pytest.approx(0.2)
    assert (speeds[3:BASE_DOFS] <= 0.2 * 1.5 + 1e-9).all()
    assert (speeds[BASE_DOFS:] <= 0.2 * robot.speed_limit + 1e-9).all()
    after = Pose(robot, configuration(kinematics))
    for side in SIDES:
        np.testing.assert_allclose(after.site(sole_site(side)), Pose(robot, standing).site(sole_site(side)), atol=1e-3)


def test_without_a_solution_the_joints_stay_inside_the_soft_limits(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(daqp, "solve", no_solution)
    for _ in range(40):
        kinematics.step(targets(robot, standing, hands={"left": np.array([1.5, 0.2, 1.5])}, reaching=1.0))
    assert (kinematics.joints >= robot.lower - 1e-9).all()
    assert (kinematics.joints <= robot.upper + 1e-9).all()


def test_with_neither_it_stays_where_it_is(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = configuration(kinematics)
    monkeypatch.setattr(daqp, "solve", no_solution)
    assert not kinematics.step(targets(robot, standing, com=np.full(3, np.nan)))
    np.testing.assert_allclose(configuration(kinematics), before, atol=1e-12)
    np.testing.assert_array_equal(kinematics.velocity, np.zeros(robot.model.nv))


def test_the_planned_motion_is_reported(robot: RobotModel, standing: Array, kinematics: InverseKinematics) -> None:
    wanted = targets(robot, standing, com=Pose(robot, standing).com + np.array([0, 0.05, 0]))
    before = kinematics.joints.copy()
    kinematics.step(wanted)
    np.testing.assert_allclose(kinematics.velocity[6:] * DT, kinematics.joints - before, atol=1e-9)
    assert np.linalg.norm(kinematics.momentum_rate) > 0
    kinematics.reset(standing)
    assert not kinematics.velocity.any()
    assert not kinematics.acceleration.any()
    assert not kinematics.momentum_rate.any()


def test_it_starts_inside_the_soft_limits(robot: RobotModel, standing: Array, kinematics: InverseKinematics) -> None:
    outside = standing.copy()
    outside[BASE_COORDINATES:] = robot.upper + 0.5
    kinematics.reset(outside)
    np.testing.assert_array_equal(kinematics.joints, robot.upper)
