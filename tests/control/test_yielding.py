"""Arms that touch something: they yield, and are stiff again without a jump."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.body.yielding import YieldingArms
from humanoid_bt.core.messages import Array, HandTarget, Mode, State
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.session.happenings import Happenings
from tests.control.control_rig import ControlRig
from tests.safety.contact_trials import LATER, Wall, into_wall
from tests.safety.machine import Machine

DT = 0.005
HAND = {"right_hand": HandTarget(np.array([0.3, -0.2, 0.9]))}


@pytest.fixture(scope="module")
def wall() -> Wall:
    return Wall()


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.trials) for seed in range(1, 6))])
def test_a_hand_that_moves_into_a_wall_yields(wall: Wall, seed: int) -> None:
    outcome = into_wall(wall, seed)
    assert outcome.good, outcome
    assert outcome.yields < 0.05


@pytest.mark.trials
def test_a_wall_is_noticed_that_is_pushed_on(wall: Wall, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wall.rig.controller.supervisor, "feel", lambda *_: None)
    assert into_wall(wall, 0).later > 40


@pytest.mark.trials
@pytest.mark.parametrize("seed", [2, 3])
def test_a_hand_that_carries_something_feels_a_wall(seed: int) -> None:
    outcome = into_wall(Wall(hand_payload=2.0), seed)
    assert outcome.yields < 0.05
    assert outcome.later < LATER
    assert outcome.stands
    assert not outcome.early


def test_an_arm_whose_joints_have_no_limits_yields(endless: RobotModel, standing: Array) -> None:
    rig = ControlRig(endless, standing)
    rig.plant.push("right_hand", np.array([0.0, -40.0, 0.0]), 0.2)
    assert rig.run(0.5, {}, until=lambda state: state.contacts["right_arm"].yields if state.contacts else False)
    rig.run(0.1, {})
    softened = rig.controller.servo.command.stiffness / endless.stiffness
    arm = endless.arm_joints("right")
    np.testing.assert_allclose(softened[arm], endless.config.contact.stiffness)
    np.testing.assert_array_equal(np.delete(softened, arm), 1.0)


def test_an_arm_moves_away_from_what_pushed_it_before_it_goes_home(rig: ControlRig) -> None:
    rig.run(2.0, HAND)
    rig.plant.push("right_hand", np.array([0.0, -40.0, 0.0]), 0.2)
    rig.run(0.4, HAND)
    assert rig.state.contacts["right_arm"].yields
    assert rig.run(2.0, {}, until=lambda state: not state.contacts)
    before = rig.state.hands["right"]
    rig.run(1.2, {})
    assert rig.state.hands["right"][1] < before[1] - 0.05
    rig.controller.supervisor.raise_estop("test", "pressed")
    rig.run(0.2, {})
    stopped = rig.state.hands["right"]
    rig.run(1.0, {})
    assert rig.state.hands["right"] == pytest.approx(stopped, abs=0.03)  # a robot that is stopped moves no arm


@pytest.mark.parametrize("stiffness", [0.9, 1.0])
def test_an_arm_that_yields_stiffly_moves_again(robot: RobotModel, standing: Array, stiffness: float) -> None:
    contact = replace(robot.config.contact, stiffness=stiffness)
    rig = ControlRig(RobotModel(replace(robot.config, contact=contact)), standing)
    rig.run(0.5, HAND)
    rig.plant.push("right_hand", np.array([0.0, -60.0, 0.0]), 0.1)
    assert rig.run(0.5, HAND, until=lambda state: bool(state.contacts) and state.contacts["right_arm"].yields)
    assert rig.run(2.0, {}, until=lambda state: not state.contacts)
    up = {"right_hand": HandTarget(np.array([0.3, -0.25, 1.15]))}
    assert rig.run(3.0, up, until=lambda state: state.hand_errors.get("right", 1.0) < 0.01)


def test_an_arm_that_is_wanted_elsewhere_does_not_go_home_first(rig: ControlRig) -> None:
    rig.run(2.0, HAND)
    rig.plant.push("right_hand", np.array([0.0, -40.0, 0.0]), 0.2)
    rig.run(0.4, HAND)
    assert rig.run(2.0, {}, until=lambda state: not state.contacts)
    assert rig.run(2.0, HAND, until=lambda state: state.hand_errors.get("right", 1.0) < 0.03)


def test_an_arm_that_is_pushed_follows_and_is_held_there(rig: ControlRig) -> None:
    rig.run(2.0, HAND)
    rig.plant.push("right_hand", np.array([-40.0, 0.0, 0.0]), 0.6)
    rig.run(0.1, HAND)
    assert rig.state.contacts["right_arm"].yields
    assert rig.state.targets == {}
    before = rig.state.hands["right"]
    rig.run(0.8, HAND)
    assert rig.state.hands["right"][0] < before[0] - 0.05
    rig.run(0.8, HAND)  # the robot steps back to catch itself, and shakes the arm
    joints = rig.robot.arm_joints("right")
    after = rig.state.joint_positions[joints]
    rig.run(2.0, HAND)  # its node goes on asking
    assert rig.state.contacts["right_arm"].yields
    assert rig.state.joint_positions[joints] == pytest.approx(after, abs=0.1)
    assert rig.state.mode is Mode.RUN


@pytest.mark.trials
def test_it_is_stiff_again_without_a_jump(rig: ControlRig) -> None:
    rig.run(2.0, HAND)
    rig.plant.push("right_hand", np.array([-40.0, 0.0, 0.0]), 0.3)
    rig.run(1.0, HAND)
    speeds: list[float] = []
    joints = rig.robot.arm_joints("right")
    rig.run(12.0, {}, cycle=lambda: speeds.append(np.abs(rig.plant.data.qvel[6:][joints]).max()))
    assert not rig.state.contacts
    assert rig.controller.servo.command.stiffness is rig.robot.stiffness
    assert max(speeds) < 1.1  # rad/s: in the end as joints that are released, at 1 rad/s
    assert rig.run(3.0, HAND, until=lambda state: state.hand_errors["right"] < 0.01)


def test_a_stopped_robot_yields_too(rig: ControlRig) -> None:
    rig.run(2.0, HAND)
    rig.controller.supervisor.raise_estop("test", "pressed")
    rig.run(0.2, HAND)
    before = rig.state.hands["right"]
    rig.plant.push("right_hand", np.array([-40.0, 0.0, 0.0]), 0.5)
    rig.run(0.5, HAND)
    assert rig.state.hands["right"][0] < before[0] - 0.05


@pytest.mark.trials
def test_a_soft_hand_does_not_drop_what_it_carries(rig: ControlRig) -> None:
    rig.plant.alter(hand_payload=1.5)
    try:
        rig.reset()
        rig.run(6.0, HAND)
        rig.plant.push("right_hand", np.array([-40.0, 0.0, 0.0]), 0.2)
        rig.run(0.5, HAND)
        assert rig.state.contacts["right_arm"].yields
        before = rig.state.hands["right"][2]
        rig.run(1.5, HAND)
        assert rig.state.hands["right"][2] > before - 0.1
    finally:
        rig.plant.alter()


def test_contact_is_told_as_an_event_when_it_begins_and_ends() -> None:
    machine = Machine()
    happenings = Happenings(machine._lockstep)
    told: list[str] = []

    def look(state: State) -> bool:
        told.extend(happening.text for happening in happenings.touches(state))
        return False

    machine.after(0.5, lambda: machine.plant.push("right_hand", np.array([-60.0, 0.0, 0.0]), 0.2))
    machine.after(2.5, lambda: machine.plant.push("torso", np.array([-90.0, 0.0, 0.0]), 0.1))
    machine.run(4000, until=look)
    assert [text.split(":")[0] for text in told] == [
        "right arm touched something",
        "nothing touches the right arm any more",
        "torso touched something",
        "nothing touches the torso any more",
    ]
    assert told[0].endswith("; the arm yields")


def test_a_robot_whose_arm_yields_no_more_does_not_jerk(rig: ControlRig) -> None:
    """The plan of the arm, which sagged meanwhile, must not jump to where it is: all of the body would answer."""
    rig.run(0.5, {})
    rig.plant.push("right_hand", np.array([-60.0, 0.0, 0.0]), 0.2)
    assert rig.run(0.3, {}, until=lambda _: bool(rig.controller.supervisor.touch.yielding))
    assert rig.run(2.0, {}, until=lambda _: not rig.controller.supervisor.touch.yielding)
    felt: list[float] = []
    rig.run(1.5, {}, cycle=lambda: felt.append(float(np.abs(rig.plant.data.qacc[:3]).max())))
    assert max(felt) < 15.0
    assert not rig.controller.supervisor.touch.yielding


def test_a_robot_that_lies_limp_feels_nothing(rig: ControlRig) -> None:
    rig.run(0.1, {})
    rig.plant.push("torso", np.array([600.0, 0.0, 0.0]), 0.2)
    assert rig.run(3.0, {}, until=lambda state: state.mode is Mode.DAMP)
    rig.run(1.0, {})
    assert not rig.state.contacts
    assert not rig.controller.supervisor.touch.yielding


def test_an_arm_that_is_pushed_to_its_stops_is_stopped_by_its_drives(rig: ControlRig) -> None:
    """Of what a mechanical stop bears nothing is felt, and what rebounds from it is felt as a push the other way."""
    pushes, nearest = [], []
    own = rig.robot.arm_joints("left")
    low, high = rig.robot.model.jnt_range[1:][own].T

    def look() -> None:
        pushes.append(rig.controller.estimator.contact.forces["left_arm"][0])
        angles = rig.plant.data.qpos[7:][own]
        nearest.append(np.minimum(angles - low, high - angles).min())

    rig.run(0.5, {})
    rig.plant.push("left_hand", np.array([-40.0, 0.0, 0.0]), 0.1)
    rig.run(0.1, {}, cycle=look)
    rig.plant.push("left_hand", np.array([-30.0, 0.0, 0.0]), 0.9)
    rig.run(0.9, {}, cycle=look)
    assert rig.state.contacts["left_arm"].yields
    assert min(nearest) > 0.02
    assert max(pushes[100:]) < -20.0


class Arm:
    """The arms of a robot whose plan is at home, and whose left arm sags."""

    def __init__(self, robot: RobotModel) -> None:
        self.home = robot.home_qpos[7:].copy()
        self.own = robot.arm_joints("left")
        self.qpos = robot.home_qpos.copy()
        self.qpos[np.array(self.own) + 7] += 0.1
        self.joints, self.still = self.home.copy(), []
        self.forces = {"left_arm": np.zeros(3)}
        dynamics: Any = SimpleNamespace(palm=lambda side: np.zeros(3))
        self.arms = YieldingArms(robot, dynamics, self, DT)

    def follow(self, joints: list[int], measured: Array, share: float) -> None:
        self.joints[joints] += share * (measured - self.joints[joints])

    def torques_of_carried(self, side: str) -> Array:
        return np.zeros_like(self.home)

    def go_on(self, seconds: float, *force: float, yields: bool = False, wanted: tuple[str, ...] = ()) -> None:
        self.arms.sides = frozenset({"left"} if yields else ())
        self.forces["left_arm"] = np.array(force or (0.0, 0.0, 0.0))
        for _ in range(round(seconds / DT)):
            self.arms.update(self.qpos, self, wanted)

    def posture(self, hold: bool = False) -> Array:
        """Return where the arm's joints are wanted when all else is, shape (joints of the arm,) [rad]."""
        posture = self.home.copy()
        self.arms.keep(posture, self.home, hold)
        return posture[self.own]


@pytest.fixture
def arm(robot: RobotModel) -> Arm:
    return Arm(robot)


def test_an_arm_that_yields_again_stays_where_it_is_left(arm: Arm) -> None:
    arm.go_on(0.05, 0.0, 30.0, 0.0, yields=True)
    arm.go_on(DT)
    before = arm.joints.copy()
    assert (before[arm.own] > arm.home[arm.own]).all()
    arm.go_on(1.0, yields=True)
    np.testing.assert_array_equal(arm.joints, before)


def test_an_arm_moves_away_from_what_pushed_it_hardest(arm: Arm) -> None:
    arm.go_on(0.1, 0.0, 30.0, 0.0, yields=True)
    arm.go_on(0.1, 10.0, 0.0, 0.0, yields=True)
    assert arm.arms.away("left") is None
    arm.go_on(0.4)
    away = arm.arms.away("left")
    assert away is not None
    assert away.position == pytest.approx([0.0, 0.1, 0.0])
    arm.go_on(DT, wanted=("left_hand",))
    assert arm.arms.away("left") is None
    assert not arm.arms.homeward  # nor does it go home
    arm.go_on(0.1, 10.0, 0.0, 0.0, yields=True)
    arm.go_on(0.4)
    again = arm.arms.away("left")
    assert again is not None
    assert again.position == pytest.approx([0.1, 0.0, 0.0])


def test_an_arm_goes_home_slowly_but_not_while_the_robot_is_held(arm: Arm) -> None:
    arm.go_on(0.1, 0.0, 30.0, 0.0, yields=True)
    arm.posture()
    arm.go_on(0.2)
    np.testing.assert_array_equal(arm.posture(), arm.joints[arm.own])  # whose plan still comes to where it is
    arm.go_on(0.2)
    while arm.arms.away("left") is not None:
        arm.posture()
    there = arm.posture(hold=True)
    assert (there > arm.home[arm.own] + 0.05).all()
    np.testing.assert_array_equal(arm.posture(hold=True), there)
    np.testing.assert_allclose(arm.posture(), there - 0.3 * DT)
