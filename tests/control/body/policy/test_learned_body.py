"""The learned body on physics: a policy that stands by stiff drives, and what is made of it.

It holds one posture whatever it is told, and so it stands: balance is not what these tests are about, but everything
around it. Published policies walk in tests/policies.
"""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from humanoid_bt.control.body.policy import inference
from humanoid_bt.control.body.policy.learned_body import LearnedBody
from humanoid_bt.control.body.policy.lending import VIEW, WAIST, Lending
from humanoid_bt.control.body.standing import load_robot, standing_posture
from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.core.messages import ArmTarget, Array, BaseTarget, Gait, GazeTarget, HandTarget, Mode
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel
from humanoid_bt.robot.policy.network import Network, Tensor
from tests.control.control_rig import ControlRig
from tests.policy_files import write_standing_robot

pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")

PLACE = np.array([0.35, 0.2, 0.95])


def standing_rig(folder: Path, robot: RobotModel, standing: Array, lend: str = "{}") -> ControlRig:
    path = write_standing_robot(folder, robot.joint_names, standing[BASE_COORDINATES:])
    with (folder / "stand.policy.yaml").open("a") as description:
        description.write(f"lend: {lend}\n")
    return ControlRig(*load_robot(path))


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory, robot: RobotModel, standing: Array) -> ControlRig:
    return standing_rig(tmp_path_factory.mktemp("stands"), robot, standing)


@pytest.fixture
def rig(shared: ControlRig) -> ControlRig:
    shared.reset()
    return shared


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """What the network's answers are multiplied by and added to, while there is anything."""
    spoilt: list[float] = []
    run = Network.run

    def spoil(network: Network, outputs: list[str], inputs: dict[str, Tensor]) -> list[Tensor]:
        return [answer + np.float32(spoilt[0]) if spoilt else answer for answer in run(network, outputs, inputs)]

    monkeypatch.setattr(Network, "run", spoil)
    return spoilt


def body_of(rig: ControlRig) -> LearnedBody:
    assert isinstance(rig.controller.body, LearnedBody)
    return rig.controller.body


def test_the_default_pose_is_how_it_stands_and_its_gains_drive_it(rig: ControlRig) -> None:
    policy = rig.robot.policy
    assert policy is not None
    assert rig.robot.home_qpos[BASE_COORDINATES:] == pytest.approx(policy.default_pose, abs=1e-5)
    rig.run(1.0, {})
    command = rig.controller.servo.command
    assert command.stiffness == pytest.approx(policy.stiffness)
    assert command.damping == pytest.approx(policy.damping)
    assert (rig.state.mode, rig.state.gait, rig.state.base_settled) == (Mode.RUN, Gait.STAND, True)
    assert rig.state.footsteps == ()
    assert rig.state.stance == pytest.approx([0, 0, 0], abs=0.01)


def test_a_hand_reaches_and_goes_home(rig: ControlRig) -> None:
    body = body_of(rig)
    before = rig.state.hands["left"]
    reached = rig.run(5, {"left_hand": HandTarget(PLACE)}, until=lambda state: state.hand_errors["left"] < 0.005)
    assert reached, f"{rig.state.hand_errors['left'] * 100:.1f} cm away"
    assert body.lending.lends("left_hand") and not body.lending.lends("right_hand")
    assert rig.run(5, {}, until=lambda _: not body.lending.busy), "the arm was not given back"
    rig.run(0.5, {})
    assert np.linalg.norm(rig.state.hands["left"] - before) < 0.02


def test_lent_arms_have_their_own_drives(rig: ControlRig) -> None:
    robot = rig.robot
    rig.run(0.5, {"left_hand": HandTarget(PLACE)})
    arm, other = robot.arm_joints("left"), robot.arm_joints("right")
    stiffness = rig.controller.servo.command.stiffness
    assert robot.policy is not None
    assert stiffness[arm] == pytest.approx(robot.stiffness[arm])
    assert stiffness[other] == pytest.approx(robot.policy.stiffness[other])


def test_nothing_jumps_when_an_arm_is_lent_and_given_back(rig: ControlRig) -> None:
    arm = rig.robot.arm_joints("left")
    steps: list[float] = []
    last = rig.controller.servo.position[arm].copy()

    def note() -> None:
        nonlocal last
        now = rig.controller.servo.position[arm]
        steps.append(float(np.abs(now - last).max()))
        last = now.copy()

    rig.run(3, {"left_hand": HandTarget(PLACE)}, cycle=note)
    rig.run(4, {}, cycle=note)
    assert max(steps) < 0.03, f"a joint's setpoint jumped by {max(steps):.3f} rad in a period"


def test_a_waist_that_is_wanted_again_while_it_is_given_back_stays_where_it_is(
    tmp_path: Path, robot: RobotModel, standing: Array
) -> None:
    rig = standing_rig(tmp_path, robot, standing, "{waist: ['waist_*']}")
    waist = body_of(rig).lending.groups[WAIST]
    rig.run(1.5, {"right_hand": HandTarget(np.array([0.55, -0.1, 0.6]))})
    rig.run(0.3, {})
    on_its_way = rig.controller.servo.position[waist].copy()
    policy, command = rig.robot.policy, rig.controller.servo.command
    assert policy is not None
    assert command.stiffness[waist] == pytest.approx(policy.stiffness[waist]), "its legs stand on that waist"
    assert np.abs(on_its_way - standing[BASE_COORDINATES:][waist]).max() > 0.02
    rig.controller.supervisor.raise_estop("test", "pressed")
    rig.run(0.1, {})
    assert rig.controller.servo.position[waist] == pytest.approx(on_its_way, abs=0.005)


def test_the_policy_is_told_what_was_done_of_a_waist_that_is_given_back(
    tmp_path: Path, robot: RobotModel, standing: Array, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = standing[BASE_COORDINATES:]
    path = write_standing_robot(tmp_path, robot.joint_names, home)
    description = tmp_path / "stand.policy.yaml"
    text = description.read_text().replace("joint_pos_rel", "last_action")
    description.write_text(text + "lend: {waist: ['waist_*'], last_action: executed}\n")
    told: list[Tensor] = []
    run = Network.run

    def note(network: Network, outputs: list[str], inputs: dict[str, Tensor]) -> list[Tensor]:
        told.append(inputs["obs"][0, 6:])
        return run(network, outputs, inputs)

    monkeypatch.setattr(Network, "run", note)
    rig = ControlRig(*load_robot(path))
    waist = body_of(rig).lending.groups[WAIST]
    for seconds, targets in ((1.5, {"right_hand": HandTarget(np.array([0.55, -0.1, 0.6]))}), (0.3, {})):
        rig.run(seconds, targets)
        done = rig.controller.servo.position[waist] - home[waist]
        assert told[-1][waist] == pytest.approx(done, abs=0.03)
    assert np.abs(done).max() > 0.02


def test_a_waist_that_is_neither_the_walkers_nor_lent_stays_at_home(
    tmp_path: Path, robot: RobotModel, standing: Array
) -> None:
    names, home = robot.joint_names, standing[BASE_COORDINATES:]
    legs = [i for i, name in enumerate(names) if any(part in name for part in ("hip", "knee", "ankle"))]
    path = write_standing_robot(tmp_path, tuple(names[i] for i in legs), home[legs])
    rig = ControlRig(*load_robot(path))
    waist = [i for i, name in enumerate(names) if name.startswith("waist")]
    rig.run(1.0, {"left_hand": HandTarget(np.array([0.6, 0.4, 0.9]))})
    assert rig.state.hands["left"][0] > 0.3
    command = rig.controller.servo.command
    assert command.position[waist] == pytest.approx(rig.robot.home_qpos[BASE_COORDINATES:][waist], abs=1e-6)
    assert np.abs(command.torque[waist]).max() > 0.5


def test_an_arm_that_is_not_lent_is_stiff_again_after_a_push(
    tmp_path: Path, robot: RobotModel, standing: Array
) -> None:
    rig = standing_rig(tmp_path, robot, standing, "{joints: []}")
    rig.run(0.2, {})
    rig.plant.push("right_hand", np.array([0.0, -60.0, 0.0]), 0.1)
    assert rig.run(0.5, {}, until=lambda state: bool(state.contacts) and state.contacts["right_arm"].yields)
    assert rig.run(8.0, {}, until=lambda _: rig.controller.body.arms.stiffness is None)


def test_the_policy_is_told_that_lent_joints_are_at_home(rig: ControlRig, monkeypatch: pytest.MonkeyPatch) -> None:
    rows: list[Tensor] = []
    run = Network.run

    def note(network: Network, outputs: list[str], inputs: dict[str, Tensor]) -> list[Tensor]:
        rows.append(inputs["obs"][0])
        return run(network, outputs, inputs)

    monkeypatch.setattr(Network, "run", note)
    rig.run(2, {"left_hand": HandTarget(PLACE)})
    arm, other = rig.robot.arm_joints("left"), rig.robot.arm_joints("right")
    seen = rows[-1][6:]
    assert not seen[arm].any()
    assert seen[other].any(), "of others it is told the truth"


def test_a_hold_keeps_the_hand_where_it_is(rig: ControlRig) -> None:
    rig.run(4, {"left_hand": HandTarget(PLACE)})
    held = rig.state.hands["left"]
    rig.run(2)  # decision is silent
    assert rig.state.mode is Mode.PROTECTIVE_STOP
    assert np.linalg.norm(rig.state.hands["left"] - held) < 0.01
    assert body_of(rig).velocity.stands


def test_joints_of_an_arm_are_held_by_name(rig: ControlRig) -> None:
    name = rig.robot.joint_names[rig.robot.arm_joints("left")[0]]
    angle = -0.6
    rig.run(4, {"left_hand": ArmTarget({name: angle})})
    assert rig.state.joint_positions[rig.robot.joint(name)] == pytest.approx(angle, abs=0.05)


def test_the_neck_turns_the_view(rig: ControlRig) -> None:
    point = np.array([2.0, 1.0, 1.0])
    rig.run(3, {"gaze": GazeTarget(point)})
    way = point - rig.state.gaze_position
    assert rig.state.gaze_direction @ way / np.linalg.norm(way) > np.cos(0.1)


def test_a_base_target_becomes_a_velocity(rig: ControlRig) -> None:
    rig.run(0.4, {"base": BaseTarget(np.array([2.0, 0.0]), 0.0)})
    vx, vy, wz = body_of(rig).velocity.command.tolist()
    assert vx > 0.4 and abs(vy) < 0.1 and abs(wz) < 0.3
    assert rig.state.gait is Gait.STEP and not rig.state.base_settled


def test_the_drives_follow_each_new_answer(rig: ControlRig, answers: list[float]) -> None:
    policy = rig.robot.policy
    assert policy is not None
    rig.run(0.5, {})
    before = rig.controller.servo.position.copy()
    answers.append(0.02)
    rig.run(0.1, {})
    moved = rig.controller.servo.position - before
    assert moved[policy.moves] == pytest.approx(0.02 * policy.scale, abs=1e-6)


def test_a_single_wrong_answer_changes_nothing(rig: ControlRig, answers: list[float]) -> None:
    rig.run(0.5, {})
    answers.append(np.nan)
    rig.run(0.02, {})
    answers.clear()
    rig.run(0.5, {})
    assert isinstance(rig.controller.body, LearnedBody)
    assert rig.state.mode is Mode.RUN
    assert any("the policy's answer is not finite" in text for text in rig.controller.supervisor.rejected)


def test_a_policy_that_fails_gives_way_to_the_model_based_body(rig: ControlRig, answers: list[float]) -> None:
    rig.run(0.5, {})
    answers.append(np.nan)
    rig.run(3, {})
    state = rig.state
    assert isinstance(rig.controller.body, WholeBody)
    assert (state.mode, state.stop_source) == (Mode.PROTECTIVE_STOP, "body")
    assert state.stop_reason == "the policy's answer is not finite"
    assert state.base_settled, "it stands"
    rig.reset()
    assert isinstance(rig.controller.body, LearnedBody), "the next run begins with the policy"


def test_a_policy_that_never_answers_gives_way_and_nothing_waits_for_it(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(inference, "PATIENCE", 0.1)
    over = Event()
    with monkeypatch.context() as stuck:
        stuck.setattr(Network, "run", lambda *_: over.wait())
        rig.run(0.06, {})
        assert rig.state.mode is Mode.RUN, "it was late twice"
        rig.run(3, {})
    over.set()
    assert isinstance(rig.controller.body, WholeBody)
    assert (rig.state.mode, rig.state.stop_reason) == (Mode.PROTECTIVE_STOP, "the policy does not answer in time")
    assert rig.controller.supervisor.stops[0].time < 0.07
    assert rig.state.base_settled, "it stands"
    rig.reset()
    rig.run(0.5, {})
    assert rig.state.mode is Mode.RUN, "the next run asks the policy again"


def test_is_deterministic(rig: ControlRig) -> None:
    targets = {"left_hand": HandTarget(PLACE), "gaze": GazeTarget(np.array([2.0, 0.0, 1.0]))}
    rig.run(1, targets)
    once = rig.plant.data.qpos.copy()
    rig.reset()
    rig.run(1, targets)
    assert (rig.plant.data.qpos == once).all()


def test_which_body_can_be_said_for_a_run(rig: ControlRig) -> None:
    robot, _ = load_robot(rig.robot.config.path, "dcm")
    assert robot.policy is None
    assert isinstance(ControlRig(robot, rig.standing).controller.body, WholeBody)
    assert standing_posture(robot) == pytest.approx(rig.standing, abs=0.02)


def test_the_view_of_a_robot_without_a_neck_takes_no_roll_from_the_walker(rig: ControlRig) -> None:
    policy = rig.robot.policy
    assert policy is not None
    lends = copy.copy(policy)
    lends.config = replace(policy.config, lend=replace(policy.config.lend, waist=["waist_*"]))
    lending = Lending(rig.robot, lends, 0.005)
    names = rig.robot.joint_names
    lending.update({VIEW: True}, np.zeros(len(names)))
    assert {names[joint] for joint in lending.joints} == {"waist_yaw", "waist_pitch"}
    lending.update({WAIST: True}, np.zeros(len(names)))
    assert {names[joint] for joint in lending.joints} == {"waist_yaw", "waist_roll", "waist_pitch"}
