"""What the contact observer feels, beside what really pushes the simulated robot."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.control.estimator.contact_observer import ContactObserver
from humanoid_bt.core.messages import TORSO, Array, BaseTarget, Estimate, Gait, HandTarget
from humanoid_bt.robot.model import RobotModel, palm_site
from tests.control.control_rig import ControlRig

AHEAD = {"left_hand": HandTarget(np.array([0.3, 0.2, 0.9]))}


def felt(rig: ControlRig, group: str) -> Array:
    """Return what is felt on average over 0.1 s, shape (3,) [N]."""
    forces: list[Array] = []
    rig.run(0.1, AHEAD, cycle=lambda: forces.append(rig.controller.estimator.contact.forces[group].copy()))
    return np.mean(forces, axis=0)


def largest(rig: ControlRig, seconds: float, targets: dict) -> dict[str, float]:
    """Return the largest forces that were felt of each group [N]."""
    found: dict[str, float] = {}

    def look() -> None:
        for group, force in rig.controller.estimator.contact.forces.items():
            found[group] = max(found.get(group, 0.0), float(np.linalg.norm(force)))

    rig.run(seconds, targets, cycle=look)
    return found


@pytest.mark.parametrize(
    "force",
    [
        (-20.0, 0.0, 0.0),
        pytest.param((0.0, 15.0, 0.0), marks=pytest.mark.trials),
        pytest.param((0.0, 0.0, 20.0), marks=pytest.mark.trials),
    ],
)
def test_feels_what_pushes_a_hand_and_from_where(rig: ControlRig, force: tuple[float, ...]) -> None:
    rig.run(2.0, AHEAD)
    rig.plant.push("left_hand", np.array(force), 0.3)
    rig.run(0.16, AHEAD)
    assert felt(rig, "left_arm") == pytest.approx(force, abs=3.0)
    assert np.linalg.norm(felt(rig, "right_arm")) < 3.0


def test_feels_what_pushes_the_torso_and_not_the_arms(rig: ControlRig) -> None:
    rig.run(0.5, {})
    rig.plant.push("torso", np.array([-80.0, 0.0, 0.0]), 0.1)
    found = largest(rig, 0.14, {})
    assert 60 < found[TORSO] < 100
    assert max(found["left_arm"], found["right_arm"]) < 12


def test_a_robot_that_walks_and_reaches_feels_nothing(rig: ControlRig) -> None:
    found = largest(rig, 4.0, {"base": BaseTarget(np.array([0.6, 0.3]), 0.5)})
    more = largest(rig, 2.0, AHEAD)
    assert max(found["left_arm"], found["right_arm"], more["left_arm"], more["right_arm"]) < 5
    assert max(found[TORSO], more[TORSO]) < 25


def test_learns_what_a_hand_carries_as_it_begins_before_it_has_lifted_a_foot(rig: ControlRig) -> None:
    rig.plant.alter(hand_payload=2.0)
    walk = {"base": BaseTarget(np.array([2.0, 0.0]), 0.5)}
    try:
        rig.reset()
        rig.run(0.06, {})
        assert rig.controller.estimator.contact.forces["left_arm"][2] < -10
        rig.run(0.3, walk)
        found = largest(rig, 2.0, walk)
        assert rig.state.gait is Gait.STEP
        assert max(found["left_arm"], found["right_arm"]) < 13  # N; 26 if it learnt slowly
    finally:
        rig.plant.alter()


def test_what_a_hand_carries_moves_with_it_and_pushes_nothing(rig: ControlRig) -> None:
    rig.plant.alter(hand_payload=2.0)
    try:
        rig.reset()
        rig.run(6.0, {})
        up = {
            "left_hand": HandTarget(np.array([0.25, 0.3, 1.1])),
            "right_hand": HandTarget(np.array([0.35, -0.1, 0.7])),
        }
        found = [largest(rig, 0.6, up), largest(rig, 0.4, {}), largest(rig, 0.6, up)]
        assert max(force for one in found for group, force in one.items() if group != TORSO) < 8
    finally:
        rig.plant.alter()


@pytest.mark.trials
def test_does_not_learn_what_presses(rig: ControlRig) -> None:
    rig.run(2.0, AHEAD)
    contact = rig.controller.estimator.contact
    contact.distrust({"left_arm"})
    rig.plant.push("left_hand", np.array([0.0, 0.0, -15.0]), 3.0)
    rig.run(2.5, AHEAD)
    assert felt(rig, "left_arm")[2] == pytest.approx(-15.0, abs=3.0)
    contact.distrust(())


def test_forgets_what_it_felt_when_a_sensor_fails(rig: ControlRig) -> None:
    rig.run(0.5, {})
    rig.plant.fail_sensor("gyro", "silent")
    rig.run(0.1, {})
    assert not any(force.any() for force in rig.controller.estimator.contact.forces.values())


class Weighed:
    """An observer of a humanoid that rests at home with a weight at its left hand."""

    def __init__(self, robot: RobotModel) -> None:
        joints = len(robot.joint_names)
        self.dynamics = RobotDynamics(robot)
        self.dynamics.update(Estimate(0.0, robot.home_qpos, np.zeros(6 + joints), np.zeros(joints), np.zeros(2)))
        self.observer = ContactObserver(robot, self.dynamics)
        self.observer.reset()
        self._lifts = np.zeros((3, 6 + joints))
        palm = robot.model.site(palm_site("left")).id
        mujoco.mj_jacSite(self.dynamics.model, self.dynamics.data, self._lifts, None, palm)

    def carried(self, kilograms: float) -> Array:
        """Return the torques that hold so much, shape (nj,) [Nm]."""
        return kilograms * GRAVITY * self._lifts[2, 6:]

    def felt(self, kilograms: float, seconds: float) -> float:
        """Hang so much at the hand; return with which force it is pushed up after a while [N]."""
        at_rest, torque = np.zeros_like(self.dynamics.bias), self.dynamics.bias[6:] + self.carried(kilograms)
        for _ in range(round(seconds / 0.005)):
            self.observer.update(at_rest, torque, 0.005)
        return float(self.observer.forces["left_arm"][2])


@pytest.fixture
def weighed(robot: RobotModel) -> Weighed:
    return Weighed(robot)


@pytest.mark.parametrize(("hangs", "carried"), [(2.0, 2.0), (8.0, 6.0)])
def test_what_hangs_at_a_hand_is_carried_up_to_what_a_hand_may_carry(
    weighed: Weighed, hangs: float, carried: float
) -> None:
    assert weighed.felt(hangs, 20.0) == pytest.approx((carried - hangs) * GRAVITY, rel=0.15, abs=0.5)
    torques = weighed.observer.torques_of_carried("left")
    np.testing.assert_allclose(torques, weighed.carried(carried), atol=0.05)


def test_it_learns_anew_what_a_hand_carries_after_a_reset(weighed: Weighed) -> None:
    first = weighed.felt(2.0, 0.3)
    weighed.felt(2.0, 10.0)
    weighed.observer.distrust({"left_arm"})
    weighed.observer.reset()
    assert not weighed.observer.torques_of_carried("left").any()
    assert not any(force.any() for force in weighed.observer.forces.values())
    assert weighed.felt(2.0, 0.3) == pytest.approx(first)


def test_what_touches_a_hand_is_nothing_that_it_carries(weighed: Weighed) -> None:
    weighed.observer.distrust({"left_arm"})
    assert weighed.felt(2.0, 10.0) == pytest.approx(-2.0 * GRAVITY, rel=0.15)
    weighed.observer.distrust({"right_arm"})
    assert weighed.felt(2.0, 20.0) == pytest.approx(0.0, abs=0.5)
