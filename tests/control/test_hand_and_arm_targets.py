"""Hands that are turned or held relative to each other, and arms by their joints: all of control, on physics."""

from __future__ import annotations

import math
from collections.abc import Mapping

import mujoco
import numpy as np
import pytest

from humanoid_bt.core.geometry import quaternion
from humanoid_bt.core.messages import (
    SIDES,
    ArmTarget,
    Array,
    BaseTarget,
    Gait,
    HandTarget,
    Mode,
    Pointing,
    Side,
    Target,
)
from humanoid_bt.robot.model import palm_site
from tests.control.body.own_links import OwnLinks
from tests.control.control_rig import ControlRig

AHEAD, LEFT, UP = np.eye(3)
PLACE = np.array([0.38, 0.2, 0.85])
FACING_IT = np.array([0.0, 1.0, 0.0, 0.0])
CLOSE = math.radians(3)


def frame(fingers: Array, facing: Array) -> Array:
    return np.column_stack([fingers, np.cross(facing, fingers), facing])


INWARD = quaternion(frame(AHEAD, -LEFT))
BOX: Mapping[str, Target] = {
    "left_hand": HandTarget(np.array([0.35, 0.12, 0.85]), INWARD),
    "right_hand": HandTarget(np.array([0.0, 0.0, 0.24]), FACING_IT, relative=True),
}


def true_palm(rig: ControlRig, side: Side) -> tuple[Array, Array]:
    """Return where a palm really is: place, shape (3,), and frame, shape (3, 3)."""
    site = rig.plant.data.site(palm_site(side))
    return site.xpos.copy(), site.xmat.reshape(3, 3) @ rig.robot.palm_axes[side]


def relative_error(rig: ControlRig, offset: Array) -> float:
    """Return how far the right palm really is from a place as seen from the left one [m]."""
    (origin, turn), (place, _) = (true_palm(rig, side) for side in SIDES)
    return float(np.linalg.norm(turn.T @ (place - origin) - offset))


@pytest.mark.parametrize(
    ("fingers", "facing"),
    [
        pytest.param(AHEAD, -LEFT, marks=pytest.mark.trials),
        pytest.param(AHEAD, -UP, marks=pytest.mark.trials),
        ((AHEAD - LEFT) / math.sqrt(2), -UP),
    ],
    ids=["in", "down", "aside"],
)
def test_a_hand_turns_as_it_is_told_without_a_jump(rig: ControlRig, fingers: Array, facing: Array) -> None:
    turns, last = [], [true_palm(rig, "left")[1]]

    def watch() -> None:
        now = true_palm(rig, "left")[1]
        turns.append(math.acos(min(1.0, (np.sum(now * last[0]) - 1) / 2)))
        last[0] = now

    wanted = frame(fingers, facing)
    assert rig.run(
        4.0,
        {"left_hand": HandTarget(PLACE, quaternion(wanted))},
        until=lambda state: state.hand_turn_errors.get("left", 9.0) < 0.01 and state.hand_errors["left"] < 0.005,
        cycle=watch,
    )
    place, turn = true_palm(rig, "left")
    assert math.acos(min(1.0, (np.sum(turn * wanted) - 1) / 2)) < CLOSE
    assert np.linalg.norm(place - PLACE) < 0.01
    assert max(turns) < 2.0 * rig.robot.config.whole_body.hand_turn_speed * 1e-3  # of a servo cycle
    assert rig.state.gait is Gait.STAND


def test_an_axis_points_where_it_is_told(rig: ControlRig) -> None:
    rig.run(3.0, {"left_hand": HandTarget(PLACE, Pointing(AHEAD))})
    assert true_palm(rig, "left")[1][:, 0] @ AHEAD > math.cos(CLOSE)
    rig.run(3.0, {"left_hand": HandTarget(PLACE, Pointing(-UP, "facing"))})
    assert true_palm(rig, "left")[1][:, 2] @ -UP > math.cos(CLOSE)
    assert rig.state.hand_errors["left"] < 0.01


@pytest.mark.trials
def test_a_hand_that_cannot_turn_so_stays_at_its_place(rig: ControlRig) -> None:
    rig.run(5.0, {"left_hand": HandTarget(PLACE, Pointing(-AHEAD))})
    state = rig.state
    assert state.hand_turn_errors["left"] > 0.3
    assert state.hand_errors["left"] < 0.03
    assert state.mode is Mode.RUN
    assert state.gait is Gait.STAND
    assert np.abs(state.setpoint_velocities).max() < 0.5  # it does not chatter


def test_both_hands_keep_to_each_other_while_they_move(rig: ControlRig) -> None:
    rig.run(4.0, BOX)
    offset = np.array([0.0, 0.0, 0.24])
    assert relative_error(rig, offset) < 0.002
    worst = 0.0
    for tick in range(100):
        place = np.array([0.35, 0.12, 0.85 + 0.1 * math.sin(0.04 * tick)])
        rig.run(0.02, {**BOX, "left_hand": HandTarget(place, INWARD)})
        worst = max(worst, relative_error(rig, offset))
    assert worst < 0.01
    assert rig.state.hand_turn_errors["right"] < CLOSE


@pytest.mark.trials
def test_both_hands_stay_when_the_robot_is_stopped(rig: ControlRig) -> None:
    rig.run(4.0, BOX)
    before = {side: true_palm(rig, side) for side in SIDES}
    rig.controller.supervisor.raise_estop("test", "stop")
    rig.run(1.5, BOX)
    assert rig.state.mode is Mode.EMERGENCY_STOP
    for side, (place, turn) in before.items():
        now = true_palm(rig, side)
        assert np.linalg.norm(now[0] - place) < 0.005
        assert math.acos(min(1.0, (np.sum(now[1] * turn) - 1) / 2)) < 0.02


@pytest.mark.trials
def test_a_hand_is_let_go_with_the_one_it_follows(rig: ControlRig) -> None:
    rig.run(3.0, BOX)
    away: Mapping[str, Target] = {**BOX, "base": BaseTarget(np.array([-2.0, 0.0]), math.pi)}
    assert rig.run(8.0, away, until=lambda state: all(palm[2] < 0.7 for palm in state.hands.values()))
    assert rig.state.gait is Gait.STEP
    assert rig.state.mode is Mode.RUN


def test_a_slow_hand_is_slow(rig: ControlRig) -> None:
    rig.run(1.0, {"left_hand": HandTarget(PLACE, speed=0.05)})
    begin = true_palm(rig, "left")[0]
    rig.run(1.0, {"left_hand": HandTarget(PLACE, speed=0.05)})
    assert np.linalg.norm(true_palm(rig, "left")[0] - begin) == pytest.approx(0.05, abs=0.005)


# ---- arms -----------------------------------------------------------------------------------------------------------


def angles(rig: ControlRig) -> dict[str, float]:
    return dict(zip(rig.robot.joint_names, rig.state.joint_positions.tolist(), strict=True))


def test_joints_of_an_arm_go_where_they_are_told_and_home_again(rig: ControlRig) -> None:
    home = angles(rig)
    wanted = {"right_elbow": -1.4, "right_shoulder_roll": -0.6}
    rig.run(2.5, {"right_hand": ArmTarget(wanted)})
    now = angles(rig)
    for name, angle in wanted.items():
        assert now[name] == pytest.approx(angle, abs=0.02)
    assert now["right_shoulder_pitch"] == pytest.approx(home["right_shoulder_pitch"], abs=0.05)
    assert now["left_elbow"] == pytest.approx(home["left_elbow"], abs=0.05)
    rig.run(3.0, {})
    assert angles(rig)["right_elbow"] == pytest.approx(home["right_elbow"], abs=0.02)
    assert rig.state.gait is Gait.STAND


@pytest.mark.parametrize(("asked", "speed"), [(0.3, 0.3), (None, 1.5), (40.0, 1.5)])
def test_joints_of_an_arm_are_no_faster_than_asked_nor_than_the_robot_is(
    rig: ControlRig, asked: float | None, speed: float
) -> None:
    index, fastest = rig.robot.joint("right_elbow"), 0.0

    def watch() -> None:
        nonlocal fastest
        fastest = max(fastest, abs(float(rig.controller.servo.command.velocity[index])))

    rig.run(0.5, {"right_hand": ArmTarget({"right_elbow": -1.8}, asked)}, cycle=watch)
    assert fastest == pytest.approx(speed, rel=0.15)


@pytest.mark.trials
def test_joints_of_an_arm_stay_when_the_robot_is_stopped(rig: ControlRig) -> None:
    rig.run(2.0, {"right_hand": ArmTarget({"right_elbow": -1.4})})
    rig.controller.supervisor.raise_estop("test", "stop")
    rig.run(1.5, {})
    assert angles(rig)["right_elbow"] == pytest.approx(-1.4, abs=0.03)


@pytest.mark.trials
def test_arms_that_are_bent_into_the_robot_stop_before_it(rig: ControlRig) -> None:
    """Both forearms across the chest, and the upper arms into it."""
    links = OwnLinks(rig.plant)
    bent: dict[str, Target] = {}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        joints = {"shoulder_pitch": -0.3, "shoulder_roll": -0.25 * sign, "shoulder_yaw": -1.7 * sign, "elbow": -1.6}
        bent[f"{side}_hand"] = ArmTarget({f"{side}_{name}": angle for name, angle in joints.items()})
    touched: set[object] = set()
    rig.run(3.0, bent, cycle=lambda: touched.update(links.touching()))
    assert not touched
    assert rig.state.mode is Mode.RUN
    assert rig.state.gait is Gait.STAND
    off = [abs(angles(rig)[name] - angle) for arm in bent.values() for name, angle in arm.joints.items()]  # type: ignore[union-attr]  # every arm was told joints
    assert max(off) > 0.1  # they would have touched


@pytest.mark.trials
def test_arms_swing_while_the_robot_walks(rig: ControlRig) -> None:
    raised = ArmTarget({"left_elbow": -1.5, "left_shoulder_pitch": -0.4})
    walk: Mapping[str, Target] = {"base": BaseTarget(np.array([0.8, 0.0]), 0.0), "left_hand": raised}
    assert rig.run(12.0, walk, until=lambda state: state.base_settled and state.stance[0] > 0.7)
    assert angles(rig)["left_elbow"] == pytest.approx(-1.5, abs=0.05)


# ---- reachable orientations -----------------------------------------------------------------------------------------


ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_yaw", "wrist_pitch", "wrist_roll")
TWISTED = ArmTarget(dict(zip([f"left_{name}" for name in ARM], [1.4, 2.1, -1.7, -0.2, -1.7, -1.1, -1.1], strict=True)))


@pytest.mark.parametrize(
    "angles",
    [
        [0.73, 1.40, -0.98, -1.96, -0.43, 0.57, 0.53],
        pytest.param([-0.95, -0.05, -0.67, -1.35, 0.88, -0.10, -1.11], marks=pytest.mark.trials),
    ],
)
def test_a_hand_that_its_arm_keeps_from_turning_gets_there_another_way(rig: ControlRig, angles: list[float]) -> None:
    """From a twisted arm the shortest way ends 34 and 12 cm away, at limits of joints."""
    robot, data = rig.robot, mujoco.MjData(rig.robot.model)
    data.qpos[:] = rig.standing
    data.qpos[np.add(robot.arm_joints("left"), 7)] = angles
    mujoco.mj_kinematics(robot.model, data)
    site = data.site(palm_site("left"))
    goal = HandTarget(site.xpos.copy(), quaternion(site.xmat.reshape(3, 3) @ robot.palm_axes["left"]))
    links, touched = OwnLinks(rig.plant), set[object]()
    rig.run(2.5, {"left_hand": TWISTED})
    assert rig.run(
        8.0,
        {"left_hand": goal},
        until=lambda state: state.hand_errors.get("left", 9.0) < 0.01 and state.hand_turn_errors["left"] < CLOSE,
        cycle=lambda: touched.update(links.touching()),
    )
    assert not touched
    assert rig.state.mode is Mode.RUN
    assert rig.state.gait is Gait.STAND


@pytest.mark.trials
@pytest.mark.parametrize("seed", range(20))
def test_a_hand_takes_a_pose_that_its_joints_allow_from_where_they_are(rig: ControlRig, seed: int) -> None:
    robot, numbers = rig.robot, np.random.default_rng(seed)
    arm, data = robot.arm_joints("left"), mujoco.MjData(robot.model)
    rig.run(3.0, {"left_hand": HandTarget(numbers.uniform([0.25, 0.05, 0.65], [0.4, 0.35, 1.05]))})
    state = rig.state
    bent = state.joint_positions[arm] + numbers.uniform(-0.5, 0.5, len(arm))
    data.qpos[:] = np.concatenate([state.base_position, state.base_quaternion, state.joint_positions])
    data.qpos[[7 + joint for joint in arm]] = np.clip(bent, robot.lower[arm] + 0.05, robot.upper[arm] - 0.05)
    mujoco.mj_kinematics(robot.model, data)
    site = data.site(palm_site("left"))
    place, wanted = site.xpos.copy(), quaternion(site.xmat.reshape(3, 3) @ robot.palm_axes["left"])
    rig.run(4.0, {"left_hand": HandTarget(place, wanted)})
    assert rig.state.hand_turn_errors["left"] < CLOSE
    assert rig.state.hand_errors["left"] < 0.01
