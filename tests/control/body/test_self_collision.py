"""Own links are kept apart, in the plan and on the simulated robot."""

from __future__ import annotations

import mink
import mujoco
import numpy as np
import pytest

from humanoid_bt.control.body.inverse_kinematics import InverseKinematics
from humanoid_bt.control.body.quadratic_program import QuadraticProgram
from humanoid_bt.control.body.self_collision import SelfCollisionLimit
from humanoid_bt.core.messages import Array, Mode
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel
from tests.control.body.hands_trials import Seen, Trials, motion
from tests.control.body.pose import Pose
from tests.control.body.test_inverse_kinematics import DT, targets
from tests.control.control_rig import ControlRig

TOGETHER, CROSSING, TRUNK = 6, 8, 9  # motions of the trials: so their links touch if nothing keeps them apart


@pytest.mark.parametrize(
    "number", [CROSSING, *(pytest.param(number, marks=pytest.mark.trials) for number in (TOGETHER, TRUNK))]
)
def test_hands_cross_meet_and_go_into_the_trunk_without_a_contact(rig: ControlRig, number: int) -> None:
    trials, seen = Trials(rig, seconds=2.0), Seen()
    trials.run(number, motion(0, number), seen)
    assert seen.motions == 1
    assert not seen.touched
    assert min(seen.nearest.values()) > 0.002
    assert rig.controller.supervisor.mode is Mode.RUN


@pytest.fixture
def limit(robot: RobotModel) -> SelfCollisionLimit:
    return SelfCollisionLimit(robot)


def configuration(limit: SelfCollisionLimit, qpos: Array) -> mink.Configuration:
    return mink.Configuration(limit.model, qpos)


def crossed(robot: RobotModel, standing: Array) -> Array:
    """Both forearms across the belly, one before the other, near each other."""
    qpos = standing.copy()
    for side, sign, lift in (("left", 1, -0.4), ("right", -1, -0.8)):
        joints = {"shoulder_pitch": lift, "shoulder_yaw": -0.9 * sign, "elbow": -1.4}
        for name, angle in joints.items():
            qpos[BASE_COORDINATES + robot.joint(f"{side}_{name}")] = angle
    return qpos


def distances(limit: SelfCollisionLimit, found: mink.Configuration) -> dict[tuple[int, int], float]:
    contact = found.data.contact
    pairs = list(map(tuple, contact.geom.tolist()))
    return {
        pair: distance for pair, distance in zip(pairs, contact.dist.tolist(), strict=True) if pairs.count(pair) == 1
    }


def test_its_rows_say_how_the_links_approach_each_other(
    robot: RobotModel, standing: Array, limit: SelfCollisionLimit
) -> None:
    found = configuration(limit, crossed(robot, standing))
    rows = limit.compute_qp_inequalities(found, DT).G
    before = distances(limit, found)
    assert len(before) > 10
    checked = 0
    near = list(map(tuple, limit._geoms.tolist()))
    for joint in range(BASE_DOFS, limit.model.nv):
        way = np.zeros(limit.model.nv)
        way[joint] = 1e-5
        moved = configuration(limit, found.integrate(way, 1.0))
        limit.compute_qp_inequalities(moved, DT)
        after = distances(limit, moved)
        for pair, row in zip(near, rows, strict=True):
            if pair in before and pair in after and abs(row[joint]) > 1e-3:
                assert after[pair] - before[pair] == pytest.approx(-row[joint] * 1e-5, rel=0.05, abs=1e-8)
                checked += 1
    assert checked > 50


def test_mujoco_measures_the_same_distances(robot: RobotModel, standing: Array, limit: SelfCollisionLimit) -> None:
    found = configuration(limit, crossed(robot, standing))
    limit.compute_qp_inequalities(found, DT)
    for (one, other), distance in distances(limit, found).items():
        measured = mujoco.mj_geomDistance(limit.model, found.data, one, other, 1.0, None)
        assert distance == pytest.approx(measured, abs=1e-6)


@pytest.fixture
def kinematics(robot: RobotModel, standing: Array) -> InverseKinematics:
    kinematics = InverseKinematics(robot, DT)
    kinematics.reset(standing)
    return kinematics


def nearest(robot: RobotModel, kinematics: InverseKinematics, one: str, other: str) -> float:
    """Return how far two of the model's own shapes are apart in the plan [m]."""
    data = mujoco.MjData(robot.model)
    data.qpos[:] = np.concatenate([kinematics.base_pose, kinematics.joints])
    mujoco.mj_kinematics(robot.model, data)
    geoms = (robot.model.geom(name).id for name in (one, other))
    return mujoco.mj_geomDistance(robot.model, data, *geoms, 1.0, None)


def inside(robot: RobotModel, standing: Array) -> Array:
    """The left arm in the torso, the pelvis and the thigh, as it may be after a fall."""
    qpos = standing.copy()
    qpos[BASE_COORDINATES + robot.joint("left_shoulder_roll")] = -0.25
    return qpos


def test_links_that_are_too_near_part(robot: RobotModel, standing: Array, kinematics: InverseKinematics) -> None:
    start = inside(robot, standing)
    kinematics.reset(start)
    parts = [("left_upper_arm", "torso"), ("left_forearm", "pelvis"), ("left_forearm", "left_thigh")]
    assert min(nearest(robot, kinematics, *pair) for pair in parts) < -0.04
    held = targets(robot, standing, posture=start[BASE_COORDINATES:])
    for _ in range(600):
        assert kinematics.step(held)
    least = min(nearest(robot, kinematics, *pair) for pair in parts)
    assert least > robot.config.collision.margin - 0.01  # a box sticks a little out of its capsules


def test_links_that_cannot_part_may_stay_and_the_body_goes_on(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics, monkeypatch: pytest.MonkeyPatch
) -> None:
    solve = QuadraticProgram.solve

    def none_may_part(program: QuadraticProgram) -> Array | None:
        return None if (program.rooms < 0).any() else solve(program)

    start = inside(robot, standing)
    kinematics.reset(start)
    before = nearest(robot, kinematics, "left_forearm", "pelvis")
    monkeypatch.setattr(QuadraticProgram, "solve", none_may_part)
    for _ in range(50):
        assert kinematics.step(targets(robot, standing, posture=start[BASE_COORDINATES:]))
    assert nearest(robot, kinematics, "left_forearm", "pelvis") > before + 0.01


def test_a_hand_that_another_link_keeps_from_its_target_knows_which(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics
) -> None:
    place = np.array([0.35, 0.0, 0.9])
    wanted = targets(robot, standing, hands={"left": place, "right": place}, reaching=1.0)
    for _ in range(300):
        kinematics.step(wanted)
    assert kinematics.hand_obstacles == {"left": "right_hand", "right": "left_hand"}
    aside = np.array([0, 0.15, 0])
    apart = targets(robot, standing, hands={"left": place + aside, "right": place - aside}, reaching=1.0)
    for _ in range(300):
        kinematics.step(apart)
    assert kinematics.hand_obstacles == {}


def test_hands_that_are_to_meet_stay_apart_where_the_solver_finds_no_solution(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(QuadraticProgram, "solve", lambda _: None)
    place = np.array([0.35, 0.0, 0.9])
    wanted = targets(robot, standing, hands={"left": place, "right": place}, reaching=1.0)
    ways = [nearest(robot, kinematics, "left_hand", "right_hand")]
    for _ in range(300):
        assert not kinematics.step(wanted)
        ways.append(nearest(robot, kinematics, "left_hand", "right_hand"))
    assert robot.config.collision.margin - 0.012 < min(ways) < ways[0] - 0.1  # they went there


def test_an_arm_that_is_out_of_reach_has_no_obstacle(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics
) -> None:
    wanted = targets(robot, standing, hands={"left": np.array([1.5, 0.3, 1.0])}, reaching=1.0)
    for _ in range(300):
        kinematics.step(wanted)
    assert kinematics.hand_obstacles == {}


def test_an_arm_is_planned_no_faster_than_its_bound(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics
) -> None:
    wanted = targets(robot, standing, hands={"left": np.array([0.3, -0.2, 1.1])}, reaching=1.0)  # at once, all the way
    arms = [i for i, name in enumerate(robot.joint_names) if "shoulder" in name or "elbow" in name or "wrist" in name]
    fastest = 0.0
    for _ in range(100):
        kinematics.step(wanted)
        fastest = max(fastest, float(np.abs(kinematics.velocity[BASE_DOFS:][arms]).max()))
    assert 2.0 < fastest < 2.6


def test_the_base_is_planned_to_rise_no_faster_than_its_bound(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics
) -> None:
    low = targets(robot, standing, com=Pose(robot, standing).com - np.array([0, 0, 0.12]))
    for _ in range(150):
        kinematics.step(low)
    fastest = 0.0
    for _ in range(100):
        kinematics.step(targets(robot, standing))  # at once, all the way
        fastest = max(fastest, float(kinematics.velocity[2]))
    assert 0.15 < fastest < 0.21


@pytest.mark.trials
def test_hands_that_lie_against_each_other_stay_apart_in_every_step(
    robot: RobotModel, standing: Array, kinematics: InverseKinematics
) -> None:
    least = 1.0
    for way in np.linspace(0.15, -0.15, 400):  # both come to the middle and pass on, palm by palm
        left, right = np.array([0.33, way, 0.92]), np.array([0.33, -way, 0.9])
        wanted = targets(robot, standing, hands={"left": left, "right": right}, reaching=1.0)
        assert kinematics.step(wanted)
        pairs = [("left_hand", "right_hand"), ("left_forearm", "right_forearm"), ("left_hand", "right_forearm")]
        least = min(least, *(nearest(robot, kinematics, *pair) for pair in pairs))
    assert least > robot.config.collision.margin - 0.012  # a box sticks a little out of its capsules
