"""A body of a user's own that goes wrong: the model-based one takes over, and control goes on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.body.body import Footstep, Setpoint
from humanoid_bt.control.body.guarded import GuardedBody
from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array, Estimate, Gait, Mode, Target
from humanoid_bt.robot.model import RobotModel
from tests.control.control_rig import ControlRig

LATER = 0.1  # s: when it goes wrong


class Late(WholeBody):
    """Answers what is changed by a test, later."""

    later = False

    def update(self, estimate: Estimate, targets: Mapping[str, Target], hold: bool) -> Setpoint:
        self.later = estimate.time > LATER
        setpoint = super().update(estimate, targets, hold)
        return self.changed(setpoint) if self.later else setpoint

    def changed(self, setpoint: Setpoint) -> Any:
        return setpoint


def rig_of(robot: RobotModel, standing: Array, cls: type[WholeBody]) -> ControlRig:
    rig = ControlRig(robot, standing)
    controller = rig.controller
    dynamics = controller.body.dynamics
    body = cls(robot, dynamics, controller.estimator.contact)
    controller._bodies.insert(0, GuardedBody(body, robot.joint_names, dynamics))
    controller.reset()
    return rig


def failed(rig: ControlRig) -> str:
    """Let the body go wrong; return why the robot stops then."""
    rig.run(0.2, {}, until=lambda _: False)  # asks for the state in every tick
    assert type(rig.controller.body) is WholeBody
    assert rig.state.mode is Mode.PROTECTIVE_STOP
    (stop,) = rig.controller.supervisor.stops
    assert stop.source == "body"
    assert np.isfinite(rig.controller.servo.setpoint).all()
    return stop.reason


def test_one_that_is_right_does_what_it_does_unguarded(robot: RobotModel, standing: Array) -> None:
    guarded, alone = rig_of(robot, standing, Late), ControlRig(robot, standing)
    for rig in (guarded, alone):
        rig.run(0.1, {})
        rig.plant.push("left_hand", np.array([0.0, 40.0, 0.0]), 0.2)
        rig.run(0.3, {})
        assert rig.state.contacts["left_arm"].yields
    assert isinstance(guarded.controller.body, GuardedBody)
    np.testing.assert_array_equal(guarded.plant.data.qpos, alone.plant.data.qpos)
    np.testing.assert_array_equal(guarded.state.stance, alone.state.stance)
    assert guarded.controller.body.arms.sides == {"left"}
    guarded.reset()
    assert not guarded.controller.body.arms.sides


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda s: replace(s, position=s.position[:12]), "position has the shape (12,), it must be (31,)"),
        (lambda s: replace(s, velocity=np.zeros(2000)), "velocity has the shape (2000,), it must be (31,)"),
        (lambda s: replace(s, torque=s.torque[None]), "torque has the shape (1, 31), it must be (31,)"),
        (lambda s: replace(s, position=None), "position has the shape (), it must be (31,)"),
        (lambda s: replace(s, position="no"), "position is a value of type str, it must be numbers of shape (31,)"),
        (lambda s: replace(s, stiffness=np.ones(12)), "stiffness has the shape (12,), it must be (31,)"),
        (
            lambda s: replace(s, damping=-np.ones(31)),
            "damping of 'left_hip_yaw' is -1, it must be finite, and 0 or more",
        ),
        (
            lambda s: replace(s, damping=np.where(np.arange(31) == 1, np.inf, 1.0)),
            "damping of 'left_hip_roll' is inf, it must be finite, and 0 or more",
        ),
        (lambda s: replace(s, stiffness=s.position * np.nan), "is nan, it must be finite, and 0 or more"),
        (lambda s: replace(s, position=np.full(31, np.inf)), "is inf, it must be finite"),
        (lambda s: None, "update returns None, it must be a Setpoint"),
        (lambda s: (s.position, s.velocity), "update returns a value of type tuple, it must be a Setpoint"),
    ],
)
def test_a_setpoint_that_cannot_be_followed_is_refused_with_its_field(
    robot: RobotModel, standing: Array, change: Callable[[Setpoint], Any], why: str
) -> None:
    class Mine(Late):
        def changed(self, setpoint: Setpoint) -> Any:
            return change(setpoint)

    reason = failed(rig_of(robot, standing, Mine))
    assert reason.startswith("the body Mine: ")
    assert reason.endswith(why)


@pytest.mark.parametrize("form", [lambda values: values.astype(np.float32), list, lambda values: values[:]])
def test_numbers_are_taken_in_any_form(robot: RobotModel, standing: Array, form: Callable[[Array], Any]) -> None:
    class Mine(Late):
        def changed(self, setpoint: Setpoint) -> Any:
            return replace(setpoint, position=form(setpoint.position), stiffness=form(np.full(31, 300.0)))

    rig = rig_of(robot, standing, Mine)
    rig.run(0.2, {})
    assert isinstance(rig.controller.body, GuardedBody)
    assert rig.controller.servo.command.stiffness.dtype == float


def test_gains_that_are_changed_after_they_were_answered_do_not_reach_the_drives(
    robot: RobotModel, standing: Array
) -> None:
    gains = np.full(31, 300.0)

    class Mine(Late):
        def changed(self, setpoint: Setpoint) -> Any:
            return replace(setpoint, stiffness=gains)

    rig = rig_of(robot, standing, Mine)
    rig.run(0.2, {})
    gains[:] = np.nan
    assert np.isfinite(rig.controller.servo.command.stiffness).all()


@pytest.mark.parametrize(
    "name", ["stance", "gait", "arms", "com_speed", "com_error", "still_for", "footsteps", "fault"]
)
def test_what_raises_as_it_is_asked_is_given_up(robot: RobotModel, standing: Array, name: str) -> None:
    class Mine(Late):
        def __getattribute__(self, asked: str) -> Any:
            if asked == name and super().__getattribute__("later"):
                raise ValueError("lost")
            return super().__getattribute__(asked)

    assert failed(rig_of(robot, standing, Mine)).startswith("ValueError: lost, raised at ")


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [
        ("gait", "stand", "gait is a value of type str, it must be a Gait"),
        ("stance", np.zeros(2), "stance has the shape (2,), it must be (3,)"),
        ("stance", [0.0, np.inf, 0.0], "stance is [0.0, inf, 0.0], it must be finite"),
        ("com_error", np.full(3, np.nan), "com_error is [nan, nan, nan], it must be finite"),
        ("com_speed", None, "com_speed is nan, it must be a number"),
        ("footsteps", [1], "footsteps has a value of type int, each must be a Footstep"),
        ("footsteps", [Footstep("middle", np.zeros(3))], "a value of type Footstep, each must be a Footstep"),
        ("footsteps", [Footstep("left", np.zeros(2))], "the pose in footsteps has the shape (2,), it must be (3,)"),
        ("hand_obstacles", [], "hand_obstacles is a value of type list, it must be a mapping of sides to links"),
        ("failure", "no more ideas", "no more ideas"),
    ],
)
def test_what_it_says_of_itself_is_what_it_must_be(
    robot: RobotModel, standing: Array, name: str, value: Any, why: str
) -> None:
    class Mine(Late):
        def __getattribute__(self, asked: str) -> Any:
            if asked == name and super().__getattribute__("later"):
                return value
            return super().__getattribute__(asked)

    assert failed(rig_of(robot, standing, Mine)).endswith(why)


def test_one_that_failed_stays_so_until_the_next_run(
    robot: RobotModel, standing: Array, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Mine(Late):
        def changed(self, setpoint: Setpoint) -> Any:
            raise SystemExit(3)

    rig = rig_of(robot, standing, Mine)
    body = rig.controller.body
    assert failed(rig).startswith("SystemExit: 3, raised at ")
    assert body.gait is Gait.STAND
    with monkeypatch.context() as patched:
        patched.setattr(body.guarded, "restart", None)  # it is not asked any more
        body.restart(rig.controller.estimator.estimate)
    assert body.failure.startswith("SystemExit: 3, raised at ")
    rig.reset()
    assert rig.controller.body is body
    assert not body.failure


def test_one_that_cannot_get_up_after_a_fall_is_given_up(robot: RobotModel, standing: Array) -> None:
    class Mine(Late):
        def restart(self, estimate: Estimate) -> None:
            if self.later:
                raise RuntimeError("in restart")
            super().restart(estimate)

    rig = rig_of(robot, standing, Mine)
    rig.run(0.2, {})
    rig.controller._stand_up(rig.controller.estimator.estimate)
    assert failed(rig).startswith("RuntimeError: in restart, raised at ")


def test_one_that_does_not_begin_is_a_mistake_at_its_line(robot: RobotModel, standing: Array) -> None:
    class Mine(Late):
        def reset(self, estimate: Estimate) -> None:
            raise RuntimeError("in reset")

    with pytest.raises(UserError, match=r"test_guarded\.py:\d+:13: error: the body Mine cannot begin a run: Runtime"):
        rig_of(robot, standing, Mine)
