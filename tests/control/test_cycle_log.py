"""The log of servo cycles: what control did, in numbers, from the other end of the ring."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.control.controller import Controller
from humanoid_bt.control.cycle_log import GAITS, MODES, NONE, CycleLog, Layout
from humanoid_bt.control.supervisor import Supervisor
from humanoid_bt.core.messages import BaseTarget, Gait, HandTarget, Mode
from humanoid_bt.link.table import TableReader, TableWriter
from tests.control.control_rig import ControlRig

WALK = {"base": BaseTarget(np.array([0.5, 0.0]), 0.0)}
REACH = {"left_hand": HandTarget(np.array([0.35, 0.2, 0.9]))}


class Logged:
    """A controller whose cycles are logged, and the reading ends."""

    def __init__(self, rig: ControlRig, folder: Path) -> None:
        self.rig, self.layout = rig, Layout.of(rig.robot.joint_names)
        paths = folder / "plans", folder / "cycles"
        self.layout.create(*paths)
        rig.controller.log = CycleLog(*map(TableWriter.open, paths), self.layout)
        self.plans, self.cycles = map(TableReader.open, paths)

    def read(self) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Return the columns of plans and of cycles."""
        (plans, _), (cycles, _) = self.plans.since(0), self.cycles.since(0)
        return self.layout.plan.split(plans), self.layout.cycle.split(cycles)


@pytest.fixture
def logged(rig: ControlRig, tmp_path: Path) -> Iterator[Logged]:
    yield Logged(rig, tmp_path)
    rig.controller.log = None


def test_every_cycle_is_there_once(logged: Logged) -> None:
    first = logged.rig.controller.cycle
    logged.rig.run(0.5, WALK)
    plans, cycles = logged.read()
    np.testing.assert_array_equal(cycles["servo"][:, 0], np.arange(first + 1, logged.rig.controller.cycle + 1))
    assert len(plans["plan"]) == 50
    assert {GAITS[int(gait)] for gait in plans["plan"][:, 1]} == {Gait.STEP}


def test_a_row_is_what_was_measured_and_set(logged: Logged) -> None:
    logged.rig.run(0.3, REACH)
    plans, cycles = logged.read()
    state = logged.rig.state
    np.testing.assert_array_equal(cycles["position"][-1], state.joint_positions)
    np.testing.assert_array_equal(cycles["velocity"][-1], state.joint_velocities)
    np.testing.assert_array_equal(cycles["torque"][-1], state.joint_torques)
    np.testing.assert_array_equal(cycles["base_position"][-1], state.base_position)
    np.testing.assert_array_equal(cycles["base_quaternion"][-1], state.base_quaternion)
    np.testing.assert_array_equal(cycles["base_velocity"][-1], state.base_linear_velocity)
    np.testing.assert_array_equal(cycles["base_rate"][-1], state.base_angular_velocity)
    np.testing.assert_array_equal(cycles["foot_force"][-1], list(state.foot_force.values()))
    np.testing.assert_array_equal(plans["setpoint"][-1], state.setpoint_positions)
    assert cycles["servo"][-1, 2] == state.command_sequence
    left, right = plans["hand_error"][-1]
    assert 0 <= left < 0.1
    assert right == NONE


def test_a_stop_is_in_the_cycle_in_which_it_is_ordered(logged: Logged) -> None:
    logged.rig.run(0.3, WALK)
    logged.rig.controller.supervisor.raise_estop("a test", "to see it")
    stopped = logged.rig.controller.cycle
    logged.rig.run(0.05, WALK)
    _, cycles = logged.read()
    modes = [MODES[int(mode)] for mode in cycles["servo"][:, 1]]
    at = cycles["servo"][:, 0].tolist().index(stopped + 1)
    assert (modes[at - 1], modes[at]) == (Mode.RUN, Mode.EMERGENCY_STOP)


def test_limp_joints_are_logged_too(logged: Logged) -> None:
    logged.rig.run(0.1)
    logged.rig.plant.push("torso", np.array([900.0, 0.0, 0.0]), 0.3)
    logged.rig.run(1.5)
    plans, cycles = logged.read()
    assert logged.rig.state.mode is Mode.DAMP
    assert np.diff(cycles["servo"][:, 0]).tolist() == [1] * (len(cycles["servo"]) - 1)
    assert (plans["plan"][0, 3], plans["plan"][-1, 3]) == (1, 0)


def test_it_changes_nothing(rig: ControlRig, logged: Logged) -> None:
    logged.rig.run(0.4, WALK)
    with_log = rig.plant.data.qpos.copy()
    controller: Controller = rig.controller
    controller.log = None
    rig.reset()
    rig.run(0.4, WALK)
    np.testing.assert_array_equal(rig.plant.data.qpos, with_log)


def test_there_is_no_command_before_the_first(logged: Logged) -> None:
    logged.rig.controller.run_cycle()
    _, cycles = logged.read()
    assert cycles["servo"][0, 2] == -1


def test_every_plan_is_there_whole_also_one_that_a_stop_cuts_short(logged: Logged) -> None:
    """Whatever follows a plan at once: another one, limp joints, joints that become stiff again."""
    controller, kinematics = logged.rig.controller, logged.rig.controller.body.kinematics
    supervisor, expected = controller.supervisor, []
    logged.rig.run(0.1, REACH)
    first = len(logged.read()[0]["plan"])
    for cycle in range(60):
        match cycle:
            case 7:  # between two plans
                supervisor.raise_estop("a test", "to see it")
            case 18:  # in the cycle after a plan, and no other plan comes
                supervisor.check = limp(supervisor)
            case 40:
                del supervisor.check
                supervisor.reset_run(1.0)
        before = controller.servo.command
        controller.run_cycle()
        command = controller.servo.command
        if command is not before:
            error = kinematics.hand_error("left")
            stiff = float(command.stiffness.any())
            left = NONE if error is None else error
            expected.append((controller.cycle, stiff, left, *command.position, *command.torque, *kinematics.com_error))
    plans, _ = logged.read()
    columns = plans["plan"][:, ::3], plans["hand_error"][:, :1], plans["setpoint"], plans["feedforward"]
    np.testing.assert_array_equal(np.hstack([*columns, plans["com_error"]])[first:], expected)
    cycles = [int(row[0] - expected[0][0]) for row in expected]
    assert cycles[:5] == [0, 7, 17, 18, 40]
    assert [row[1] for row in expected[3:5]] == [False, True]


def limp(supervisor: Supervisor) -> Callable[..., None]:
    """Return a check that lets the drives go."""

    def check(*_: object) -> None:
        supervisor.mode = Mode.DAMP

    return check
