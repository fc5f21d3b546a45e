"""The whole control layer on real physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

import mujoco
import numpy as np
import pytest

from humanoid_bt.control.body.body import Setpoint
from humanoid_bt.control.body.body_task import BodyTargets
from humanoid_bt.control.body.footsteps import FootstepPlanner
from humanoid_bt.control.body.inverse_kinematics import InverseKinematics
from humanoid_bt.control.body.planar import ahead, seen_from
from humanoid_bt.control.body.quadratic_program import QuadraticProgram
from humanoid_bt.core.clock import WHOLE_BODY_PERIOD, cycles
from humanoid_bt.core.messages import (
    SIDES,
    ArmTarget,
    Array,
    BaseTarget,
    Estimate,
    Gait,
    GazeTarget,
    HandTarget,
    Mode,
    PostureTarget,
    State,
    Target,
)
from humanoid_bt.link.wire import decode_state, encode_state
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel, palm_site, sole_site
from tests.control.control_rig import ControlRig

FORWARD = {"base": BaseTarget(np.array([1.0, 0.0]), 0.0)}
FAR = {"base": BaseTarget(np.array([3.0, 0.0]), 0.0)}
BALL = np.array([0.35, 0.2, 0.9])
PERIOD = cycles(WHOLE_BODY_PERIOD)
REACH = {"left_hand": HandTarget(BALL)}


def walking(state: State) -> bool:
    return state.gait is Gait.STEP and state.base_position[0] > 0.2


def drift(rig: ControlRig, seconds: float) -> float:
    """Return how far the centre of mass really moves in that time [m]."""
    com = rig.plant.data.body(rig.robot.config.base).subtree_com
    before = com.copy()
    rig.run(seconds)
    return float(np.linalg.norm(com - before))


def test_it_stands_still(rig: ControlRig, standing: Array) -> None:
    rig.run(3.0, {})
    state = rig.state
    np.testing.assert_allclose(rig.plant.truth().base_position, standing[:3], atol=3e-3)
    np.testing.assert_allclose(state.base_position, standing[:3], atol=5e-3)
    np.testing.assert_allclose(state.stance, [0, 0, 0], atol=5e-3)
    np.testing.assert_allclose(state.joint_positions, standing[BASE_COORDINATES:], atol=5e-3)
    assert state.gait is Gait.STAND
    assert state.base_settled
    assert state.mode is Mode.RUN
    assert state.limit_flags == ()


def test_it_walks_a_meter_and_stands_there(rig: ControlRig) -> None:
    assert rig.run(9.0, FORWARD, until=lambda state: state.time > 2 and state.base_settled)
    state = rig.state
    assert np.linalg.norm(state.stance - [1, 0, 0]) < 0.03
    assert rig.controller.supervisor.stops == []
    assert rig.plant.external_force_max == 0
    assert drift(rig, 0.1) < 1.8e-3  # as slow as one that has settled is


@pytest.mark.parametrize("kind", [int, np.float32])
def test_numbers_of_any_kind_say_where_to_stand(rig: ControlRig, kind: type) -> None:
    walk = BaseTarget(np.array([1, 0], dtype=kind), kind(1))
    assert rig.run(0.6, {"base": walk}, until=lambda state: state.gait is Gait.STEP)


def test_a_released_walk_ends_in_a_stand_before_the_goal(rig: ControlRig) -> None:
    assert rig.run(5.0, FAR, until=walking)
    assert rig.state.footsteps
    assert rig.run(4.0, {}, until=lambda state: state.base_settled)
    state = rig.state
    assert state.mode is Mode.RUN
    assert state.base_position[0] < 1.0
    assert state.footsteps == ()


def test_an_emergency_stop_while_walking_ends_in_a_stable_stand(rig: ControlRig) -> None:
    targets = {**FAR, "right_hand": HandTarget(np.array([0.55, -0.25, 0.8]))}
    assert rig.run(5.0, targets, until=walking)
    before = rig.state
    rig.controller.supervisor.raise_estop("test", "pressed")
    assert rig.run(4.0, targets, until=lambda state: state.base_settled)  # decision goes on commanding
    state = rig.state
    assert state.mode is Mode.EMERGENCY_STOP
    assert (state.stop_reason, state.stop_source) == ("pressed", "test")
    assert state.targets == {}
    palms = [seen_from(moment.stance, moment.hands["right"]) for moment in (before, state)]
    np.testing.assert_allclose(*palms, atol=0.06)  # it comes along while the body comes to rest
    setpoints = state.setpoint_positions
    rig.run(1.0, targets)
    assert rig.state.mode is Mode.EMERGENCY_STOP
    np.testing.assert_allclose(rig.state.setpoint_positions, setpoints, atol=0.02)
    assert np.linalg.norm(rig.state.base_position - state.base_position) < 8e-3  # it sways back by 4 to 6 mm


@pytest.mark.parametrize("phase", range(0, PERIOD, 2))
def test_an_emergency_stop_is_planned_in_the_very_next_servo_cycle(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch, phase: int
) -> None:
    rig.run(0.3, REACH)
    for _ in range(phase):
        rig.controller.run_cycle()
    plans: list[tuple[int, bool]] = []
    update = rig.controller.body.update

    def spy(estimate: Estimate, targets: Mapping[str, Target], hold: bool) -> Setpoint:
        plans.append((rig.controller.cycle, hold))
        return update(estimate, targets, hold)

    monkeypatch.setattr(rig.controller.body, "update", spy)
    raised = rig.controller.cycle
    rig.controller.supervisor.raise_estop("test", "pressed")
    for _ in range(2 * PERIOD + 1):
        rig.controller.run_cycle()
    assert plans == [(raised, True), (raised + PERIOD, True), (raised + 2 * PERIOD, True)]


def test_an_arm_that_is_to_yield_yields_in_the_very_next_servo_cycle(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig.run(1.0, REACH)
    controller, plans = rig.controller, set()
    update, touch = controller.body.update, controller.supervisor.touch

    def spy(estimate: Estimate, targets: Mapping[str, Target], hold: bool) -> Setpoint:
        plans.add(controller.cycle)
        return update(estimate, targets, hold)

    monkeypatch.setattr(controller.body, "update", spy)
    for phase in range(0, PERIOD, 5):
        rig.reset()
        rig.run(0.5, REACH)
        for _ in range(phase):
            controller.run_cycle()
        rig.plant.push("left_hand", np.array([-60.0, 0.0, 0.0]), 0.2)
        while not touch.yielding:
            controller.run_cycle()
        felt = controller.cycle
        controller.run_cycle()
        assert felt in plans


def test_after_a_reset_commands_are_followed_again(rig: ControlRig) -> None:
    rig.run(0.2, {})
    rig.controller.supervisor.raise_estop("test", "pressed")
    rig.run(0.3, REACH)
    assert rig.state.hand_errors == {}
    assert rig.controller.supervisor.reset() == ""
    assert rig.run(3.0, REACH, until=lambda state: state.hand_errors.get("left", 1.0) < 0.02)
    assert rig.state.mode is Mode.RUN


def test_silent_decision_while_walking_ends_in_a_stand(rig: ControlRig) -> None:
    assert rig.run(5.0, FAR, until=walking)
    rig.run(0.08)
    assert rig.state.mode is Mode.RUN
    rig.run(0.04)
    assert rig.state.mode is Mode.PROTECTIVE_STOP
    assert rig.stands()
    assert rig.state.base_position[0] < 1.0
    rig.run(0.04, {})
    assert rig.state.mode is Mode.RUN


@pytest.mark.trials
def test_a_hand_is_let_go_when_its_target_stays_behind_a_walking_robot(rig: ControlRig) -> None:
    assert rig.run(12.0, {**FAR, **REACH}, until=lambda state: state.time > 2 and state.base_settled)
    state = rig.state
    assert state.mode is Mode.RUN
    np.testing.assert_allclose(state.stance[:2], [3.0, 0.0], atol=0.03)
    forward, aside = seen_from(state.stance, state.hands["left"])
    assert forward > 0.0
    assert 0.15 < aside < 0.4  # it hangs at its side


def test_silent_decision_while_reaching_holds_the_hand_where_it_is(rig: ControlRig) -> None:
    rig.run(0.5, REACH)
    rig.run(0.2)
    held = rig.state
    assert held.mode is Mode.PROTECTIVE_STOP
    assert np.linalg.norm(held.hands["left"] - BALL) > 0.05  # it was on its way
    rig.run(1.0)
    np.testing.assert_allclose(rig.state.hands["left"], held.hands["left"], atol=8e-3)
    np.testing.assert_allclose(rig.state.setpoint_positions, held.setpoint_positions, atol=0.06)
    assert rig.run(3.0, REACH, until=lambda state: state.hand_errors.get("left", 1.0) < 0.02)


def test_a_hand_reaches_and_returns(rig: ControlRig, standing: Array) -> None:
    assert rig.run(4.0, REACH, until=lambda state: state.hand_errors["left"] < 0.002)
    rig.run(3.0, {})
    arm = slice(rig.robot.joint("left_shoulder_pitch"), rig.robot.joint("left_elbow") + 1)
    home = standing[BASE_COORDINATES:]
    np.testing.assert_allclose(rig.state.joint_positions[arm], home[arm], atol=0.05)


def test_gaze_and_height_are_followed(rig: ControlRig) -> None:
    point = np.array([1.0, 1.0, 0.9])
    height = rig.state.com[2]
    rig.run(1.5, {"gaze": GazeTarget(point), "posture": PostureTarget(-0.03)})
    state = rig.state
    aim = point - state.gaze_position
    assert state.gaze_direction @ aim / np.linalg.norm(aim) > np.cos(0.1)
    assert state.com[2] - height == pytest.approx(-0.03, abs=0.01)
    rig.run(1.5, {})
    assert rig.state.com[2] == pytest.approx(height, abs=5e-3)
    assert rig.state.gaze_direction[0] > 0.99


@pytest.mark.parametrize("direction", [2.0, *(pytest.param(angle, marks=pytest.mark.trials) for angle in (0.0, 4.0))])
def test_a_push_while_walking_is_survived(rig: ControlRig, direction: float) -> None:
    assert rig.run(5.0, FAR, until=walking)
    rig.plant.push("torso", 60 * np.array([np.cos(direction), np.sin(direction), 0]), 0.1)
    rig.run(1.0, FAR)
    assert rig.run(4.0, {}, until=lambda state: state.base_settled)
    assert rig.state.mode is Mode.RUN
    assert rig.plant.external_force_max > 30


def test_a_strong_push_ends_limp_on_the_ground_and_nothing_blows_up(rig: ControlRig, robot: RobotModel) -> None:
    rig.run(0.3, REACH)
    rig.plant.push("torso", np.array([600.0, 0, 0]), 0.2)
    assert rig.run(3.0, REACH, until=lambda state: state.mode is Mode.DAMP)
    assert rig.state.stop_reason.startswith("the robot is falling")
    assert rig.controller.supervisor.stops[-1].resources == {"left_hand": "root/left_hand"}
    assert not rig.controller.servo.command.stiffness.any()
    rig.run(2.0, REACH)
    state = rig.state
    assert state.mode is Mode.DAMP
    for values in (state.joint_positions, state.joint_velocities, state.base_position, state.joint_torques):
        assert np.isfinite(values).all()
    assert state.base_position[2] < 0.4
    assert not state.base_settled
    friction = np.clip(-robot.damping * state.joint_velocities, -robot.torque_limit, robot.torque_limit)
    np.testing.assert_allclose(state.joint_torques, friction, atol=2.0)
    assert "falling" in rig.controller.supervisor.reset()


def test_a_robot_put_back_on_its_feet_stands_softly_after_reset(rig: ControlRig, standing: Array) -> None:
    rig.run(0.1, {})
    rig.plant.push("torso", np.array([600.0, 0, 0]), 0.2)
    rig.run(3.0, {}, until=lambda state: state.mode is Mode.DAMP)
    rig.run(0.5)
    again = standing.copy()
    again[0] += 0.4
    again[BASE_COORDINATES + rig.robot.joint("left_shoulder_pitch")] -= 0.5  # people do not put an arm back exactly
    rig.plant.data.qpos[:] = again
    rig.plant.data.qvel[:] = 0
    gravity = rig.plant.model.opt.gravity.copy()
    rig.plant.model.opt.gravity[:] = 0  # people hold it, until the estimate is right
    rig.run(0.5)
    rig.plant.model.opt.gravity[:] = gravity
    assert rig.controller.supervisor.mode is Mode.DAMP
    assert rig.controller.supervisor.reset() == ""
    fastest = 0.0
    for _ in range(60):
        rig.run(0.02, {})
        fastest = max(fastest, float(np.abs(rig.state.joint_velocities).max()))
    state = rig.state
    assert state.mode is Mode.RUN
    assert state.base_settled
    assert fastest < 2.0
    np.testing.assert_allclose(rig.plant.truth().base_position[:2], again[:2], atol=0.02)  # odometry did not see it
    np.testing.assert_allclose(state.joint_positions, standing[BASE_COORDINATES:], atol=0.05)


def test_while_the_plant_is_silent_the_setpoint_waits(rig: ControlRig, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the plant does: a plan that went on meanwhile would come as a blow."""
    assert rig.run(5.0, FAR, until=walking)
    servo, setpoints = rig.controller.servo, []
    rig.silence(monkeypatch, 0.1)
    rig.run(0.02, FAR)
    moved = servo.setpoint[1].copy()
    rig.run(0.08, FAR, cycle=lambda: setpoints.append(servo.setpoint.copy()))
    assert np.abs(moved).max() > 1.0  # rad/s
    for setpoint in setpoints[1:]:
        np.testing.assert_array_equal(setpoint[0], setpoints[1][0])
        assert not setpoint[1].any()
    assert setpoints[-1][2].any()  # held by the torque that carried it
    rig.run(0.04, FAR, cycle=lambda: setpoints.append(servo.setpoint.copy()))
    moves = np.diff(np.array(setpoints)[:, 0], axis=0)
    assert 0.001 < np.abs(moves).max() < 0.08  # rad in a period: it goes on from there


def test_setpoints_that_are_refused_are_told_and_end_in_a_protective_stop(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig.run(0.1, {})
    before = rig.state.setpoint_positions
    feedforward = rig.controller.body._feedforward
    nan = np.full(len(before), np.nan)
    with monkeypatch.context() as patch:
        patch.setattr(feedforward, "torques", lambda *_: nan)
        rig.run(0.18, {})
        assert rig.state.mode is Mode.RUN
        np.testing.assert_array_equal(rig.state.setpoint_positions, before)
        rig.run(0.06, {})
        assert rig.state.mode is Mode.PROTECTIVE_STOP
        assert rig.state.stop_reason == "the setpoint is not finite for more than 200 ms"
        assert len(rig.controller.supervisor.rejected) == 1
        assert "not finite" in rig.controller.supervisor.rejected[0]
    rig.run(0.1, {})
    assert rig.state.mode is Mode.RUN


def test_inverse_kinematics_without_a_solution_holds_then_stops(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_solution(_: QuadraticProgram) -> None:
        return None

    rig.run(0.3, REACH)
    before = rig.state.setpoint_positions
    with monkeypatch.context() as patch:
        patch.setattr(QuadraticProgram, "solve", no_solution)
        rig.run(0.18, REACH)
        assert rig.state.mode is Mode.RUN
        np.testing.assert_allclose(rig.state.setpoint_positions, before, atol=0.02)  # it only balances
        rig.run(0.06, REACH)
        assert rig.state.mode is Mode.PROTECTIVE_STOP
        assert "without a solution" in rig.state.stop_reason
    assert rig.run(4.0, REACH, until=lambda state: state.hand_errors.get("left", 1.0) < 0.02)


def test_the_foot_that_it_turns_about_holds_on_to_the_floor(rig: ControlRig, monkeypatch: pytest.MonkeyPatch) -> None:
    """A leg that swings would turn it, if arms and trunk did not turn against it."""
    turned: list[float] = []
    monkeypatch.setattr(FootstepPlanner, "stood", lambda _, angle: turned.append(abs(angle)))
    behind = {"base": BaseTarget(np.array([-0.5, -0.9]), -2.7)}
    assert rig.run(8.0, behind, until=lambda state: state.time > 2 and state.base_settled)
    assert len(turned) > 6
    assert max(turned) < 0.1  # rad; 0.3 if only the legs turned


def test_knees_straighten_in_long_steps_unless_an_arm_is_busy(rig: ControlRig) -> None:
    """Legs that are stretched, and a hand that is held out, would make it hop."""

    def carrying_knees(targets: Mapping[str, Target]) -> float:
        angles: list[float] = []
        rig.reset()
        rig.run(1.5, {**FAR, **targets})
        for _ in range(60):
            rig.run(0.02, {**FAR, **targets})
            if swing := rig.controller.body.walker.swing:
                carries = "right" if swing.side == "left" else "left"
                angles.append(rig.state.joint_positions.item(rig.robot.joint(f"{carries}_knee")))
        return float(np.median(angles))

    home = rig.standing.item(7 + rig.robot.joint("left_knee"))
    assert carrying_knees({}) < home - 0.15
    assert carrying_knees({"right_hand": ArmTarget({"right_elbow": -1.0})}) > home - 0.1


def test_with_a_hand_out_it_walks_on_soles_that_lie_flat(rig: ControlRig) -> None:
    """Bent by the hand it would hop, and tip over the edge of the foot that carries it."""
    tips: list[float] = []  # sines
    for _ in range(200):
        palm = np.array([*ahead(rig.state.stance, 0.3, 0.2)[:2], 0.9])
        rig.run(0.02, {"base": BaseTarget(np.array([3.0, 0.0]), 0.0), "left_hand": HandTarget(palm)})
        if swing := rig.controller.body.walker.swing:
            carries = "right" if swing.side == "left" else "left"
            tips.append(abs(rig.plant.data.body(f"{carries}_foot").xmat[6]))
    assert rig.state.base_position[0] > 1.0
    assert max(tips) < 0.025  # 0.05 as firm as robots are by default


def test_the_plan_knows_which_foot_is_in_the_air(rig: ControlRig, monkeypatch: pytest.MonkeyPatch) -> None:
    step, told = InverseKinematics.step, set()

    def watched(kinematics: InverseKinematics, targets: BodyTargets) -> bool:
        swing = rig.controller.body.walker.swing
        told.add((targets.swings, swing.side if swing else None))
        return step(kinematics, targets)

    monkeypatch.setattr(InverseKinematics, "step", watched)
    rig.run(2.0, FORWARD)
    assert told == {(None, None), ("left", "left"), ("right", "right")}


# ---- the state ------------------------------------------------------------------------------------------------------


def test_the_state_says_where_everything_is(rig: ControlRig, robot: RobotModel) -> None:
    rig.run(1.7, {"base": BaseTarget(np.array([1.5, 0.5]), 0.6), **REACH})
    state, estimate = rig.state, rig.controller.estimator.estimate
    truth = mujoco.MjData(rig.plant.model)  # of what is believed
    truth.qpos[:], truth.qvel[:] = estimate.qpos, estimate.qvel
    mujoco.mj_forward(rig.plant.model, truth)
    assert state.cycle == 1700
    assert state.time == pytest.approx(1.7)
    np.testing.assert_array_equal(state.base_position, estimate.qpos[:3])
    np.testing.assert_array_equal(state.base_quaternion, estimate.qpos[3:7])
    np.testing.assert_array_equal(state.joint_positions, estimate.qpos[BASE_COORDINATES:])
    np.testing.assert_array_equal(state.joint_velocities, estimate.qvel[6:])
    np.testing.assert_array_equal(state.joint_torques, estimate.joint_torque)
    for side in SIDES:
        np.testing.assert_allclose(state.hands[side], truth.site(palm_site(side)).xpos, atol=1e-9)
        sole, foot = truth.site(sole_site(side)), state.feet[side]
        np.testing.assert_allclose([foot.x, foot.y, foot.z], sole.xpos, atol=1e-9)
        assert foot.yaw == pytest.approx(np.arctan2(sole.xmat[3], sole.xmat[0]))
    np.testing.assert_allclose(state.com, truth.subtree_com[1], atol=1e-9)
    np.testing.assert_allclose(state.gaze_position, truth.site("hbt_gaze").xpos, atol=1e-9)
    np.testing.assert_allclose(state.gaze_direction, truth.site("hbt_gaze").xmat.reshape(3, 3)[:, 0], atol=1e-9)
    assert state.hand_errors == {"left": pytest.approx(np.linalg.norm(state.hands["left"] - BALL))}
    assert state.command_sequence == rig.sequence
    assert state.command_sources == {"base": "root/base", "left_hand": "root/left_hand"}
    assert state.targets["left_hand"] is REACH["left_hand"]
    assert state.gait is Gait.STEP
    assert not state.base_settled
    assert [side for side, _ in state.footsteps] in (["left", "right"] * 2, ["right", "left"] * 2)
    middle = [(state.feet["left"].x + state.feet["right"].x) / 2, (state.feet["left"].y + state.feet["right"].y) / 2]
    np.testing.assert_allclose(state.stance[:2], middle, atol=0.02)


def test_a_state_does_not_change_later(rig: ControlRig) -> None:
    rig.run(1.0, FAR)
    state = rig.state
    kept = decode_state(encode_state(state))
    rig.run(0.3, {**FAR, **REACH})
    for field in fields(state):
        now, then = getattr(state, field.name), getattr(kept, field.name)
        if isinstance(now, np.ndarray):
            np.testing.assert_array_equal(now, then, err_msg=field.name)
        elif field.name in ("hands", "hand_orientations"):
            for side in SIDES:
                np.testing.assert_array_equal(now[side], then[side])
        elif field.name not in ("targets", "footsteps"):
            assert now == then, field.name


def test_nobody_can_write_into_a_state(rig: ControlRig) -> None:
    rig.run(0.1, REACH)
    state = rig.state
    values = [getattr(state, field.name) for field in fields(state)]
    mappings = [value for value in values if isinstance(value, Mapping)]
    for inner in [*values, *(part for mapping in mappings for part in mapping.values())]:
        if isinstance(inner, np.ndarray):
            assert not inner.flags.writeable
    assert len(mappings) > 5
    assert not any(hasattr(mapping, "__setitem__") for mapping in mappings)


def test_looking_does_not_change_what_happens(rig: ControlRig) -> None:
    """Asking for the state between the periods of the whole-body loop has no effect on it."""
    traces = []
    for looks in (False, True):
        rig.reset()
        for _ in range(300):
            if rig.controller.cycle % 20 == 0:
                rig.command(FAR)
            if looks:
                rig.controller.state()
            rig.controller.run_cycle()
        traces.append(rig.plant.data.qpos)
    np.testing.assert_array_equal(*traces)


def test_a_second_run_is_bit_identical_to_the_first(robot: RobotModel, standing: Array) -> None:
    def trace(rig: ControlRig) -> list[bytes]:
        samples = []
        targets = {"base": BaseTarget(np.array([0.3, 0.0]), 0.0), **REACH, "posture": PostureTarget(-0.02)}
        for _ in range(12):
            rig.run(0.1, targets)
            state = rig.state
            samples.append(state.joint_positions.tobytes() + state.setpoint_positions.tobytes() + state.com.tobytes())
        return samples

    fresh = ControlRig(robot, standing)
    first = trace(fresh)
    fresh.plant.push("torso", np.array([600.0, 0, 0]), 0.2)
    fresh.run(1.5, FAR)  # the second run begins after a fall
    fresh.controller.supervisor.raise_estop("test", "pressed")
    fresh.reset()
    assert trace(fresh) == first
