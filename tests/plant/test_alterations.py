"""A plant whose drives hear of commands late, and whose encoders are off, in physics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.messages import Array, JointCommand
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.robot.model import RobotModel
from tests.plant.drives import given
from tests.sensors import EXACT

ERROR = 0.03  # rad


class Standing:
    """A plant with the built-in robot at its start, sensors that say what is, and what holds it there."""

    def __init__(self, delay: float = 0.0, encoders: Array | None = None) -> None:
        robot, self.start = load_robot(Workspace(builtin_root()).find_robot("humanoid"))
        self.robot = RobotModel(replace(robot.config, sensors=EXACT))
        self.plant = MujocoPlant(self.robot, Scene(SceneConfig(format=1, name="empty"), 0))
        self.plant.alter(drive_delay=delay, encoders=encoders)
        self.plant.place(self.start)
        self.joints = self.start[7:]

    def command(self, position: Array | None = None, torque: float = 0.0) -> JointCommand:
        zeros = np.zeros_like(self.joints)
        where = self.joints if position is None else position
        return JointCommand(where, zeros, self.robot.stiffness, self.robot.damping, zeros + torque)

    def hold(self, cycles: int) -> Array:
        """Hold the joints where their encoders are to show them; return where they are, shape (nj,) [rad]."""
        for _ in range(cycles):
            self.plant.step(self.command())
        return self.plant.data.qpos[7:].copy()

    def torques(self, commands: list[JointCommand]) -> list[float]:
        """Return what the last drive gives in the cycle of each command."""
        found = []
        for command in commands:
            self.plant.step(command)
            found.append(float(self.plant.measure().joint_torque[-1]))
        return found


def test_drives_hear_of_a_command_as_many_cycles_later_as_they_are_late() -> None:
    def begins(standing: Standing) -> int:
        commands = [standing.command()] * 5 + [standing.command(torque=2.0)] * 10
        return next(index for index, torque in enumerate(standing.torques(commands)) if torque > 1.0)

    assert begins(Standing()) == 5
    assert begins(Standing(delay=0.003)) == 8


def test_nothing_that_was_under_way_arrives_in_the_next_run() -> None:
    standing = Standing(delay=0.003)
    standing.torques([standing.command(torque=2.0)] * 5)
    standing.plant.place(standing.start)
    assert max(standing.torques([standing.command()] * 5)) < 1.0


def test_an_encoder_that_is_off_shows_it_and_holds_its_joint_where_it_is_not() -> None:
    errors = np.zeros(len(Standing().joints))
    errors[-1] = ERROR
    standing = Standing(encoders=errors)
    true = standing.hold(400)
    np.testing.assert_allclose(standing.plant.measure().joint_position - true, errors, atol=1e-9)
    assert (true - Standing().hold(400))[-1] == pytest.approx(-ERROR, rel=0.1)


def test_what_was_altered_is_as_before_when_it_is_no_more() -> None:
    standing = Standing(delay=0.003, encoders=np.full_like(Standing().joints, ERROR))
    standing.hold(10)
    standing.plant.alter()
    standing.plant.place(standing.start)
    np.testing.assert_array_equal(standing.hold(50), Standing().hold(50))


def test_what_it_is_told_is_left_as_it_was() -> None:
    standing = Standing(encoders=np.full_like(Standing().joints, ERROR))
    command = standing.command(standing.joints.copy())
    standing.plant.step(command)
    np.testing.assert_array_equal(command.position, standing.joints)


def test_what_it_carries_and_its_friction_are_what_was_said_last() -> None:
    standing = Standing()
    model, hands = standing.plant.model, [hand.body for hand in standing.robot.config.hands.values()]
    mass, friction = model.body_mass.copy(), model.geom_friction.copy()
    for payload, carried, grip in ((3.0, 1.0, 0.5), (3.0, 2.0, 0.5), (0.0, 0.0, 1.0)):
        standing.plant.alter(payload=payload, hand_payload=carried, friction=grip)
        expected = mass.copy()
        expected[model.body(standing.robot.config.torso).id] += payload
        expected[[model.body(hand).id for hand in hands]] += carried
        np.testing.assert_allclose(model.body_mass, expected)
        assert model.body_subtreemass[0] == pytest.approx(expected.sum())
        np.testing.assert_allclose(model.geom_friction, grip * friction)


def test_weak_drives_give_a_part_of_what_they_are_asked_for_and_of_the_largest() -> None:
    standing = Standing()
    robot, plant, zeros = standing.robot, standing.plant, np.zeros_like(standing.joints)

    def give(command: JointCommand, share: float) -> bool:
        before = plant.measure()
        plant.step(command)
        after = plant.measure()
        return np.allclose(after.joint_torque, share * given(command, before, after, robot.torque_limit), atol=1e-9)

    plant.alter(drives=0.5)
    for stiffness, damping in ((1.0, 1.0), (1.0, 0.1), (0.1, 1.0)):
        plant.place(standing.start)
        gains = robot.stiffness * stiffness, robot.damping * damping
        command = JointCommand(standing.joints + 0.01, zeros + 0.1, *gains, zeros + 1.0)
        assert give(command, 0.5)
        plant.set_strength(zeros + 0.6)  # of which the command that they have knows nothing
        assert give(command, 0.3)
        assert give(replace(command, damping=2 * gains[1]), 0.3)
        assert give(replace(command, torque=zeros - 1e4), 0.3)


def test_the_last_command_of_a_run_is_heard_as_the_first_of_the_next() -> None:
    standing = Standing()
    command = standing.command(torque=2.0)
    (first,) = standing.torques([command])
    standing.plant.place(standing.start)
    assert standing.torques([command]) == [first]
