"""A plant behind a slow bus and bad encoders, in physics."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.messages import Array, JointCommand
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.imperfect import ImperfectPlant
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig

ERROR = 0.03  # rad


class Standing:
    """A plant with the built-in robot at its start, and what holds it there."""

    def __init__(self) -> None:
        robot, start = load_robot(Workspace(builtin_root()).find_robot("humanoid"))
        self.plant = MujocoPlant(robot, Scene(SceneConfig(format=1, name="empty"), 0))
        self.plant.place(start)
        self.driven = ImperfectPlant(self.plant)
        self.robot, self.joints = robot, start[7:]

    def command(self, position: Array | None = None, torque: float = 0.0) -> JointCommand:
        zeros = np.zeros_like(self.joints)
        where = self.joints if position is None else position
        return JointCommand(where, zeros, self.robot.stiffness, self.robot.damping, zeros + torque)

    def torques(self, commands: list[JointCommand]) -> list[float]:
        """Return what the last drive gives in the cycle of each command."""
        found = []
        for command in commands:
            self.driven.step(command)
            found.append(float(self.driven.measure().joint_torque[-1]))
        return found


@pytest.fixture
def standing() -> Standing:
    return Standing()


def test_it_is_as_good_as_the_plant_until_it_is_altered(standing: Standing) -> None:
    bare = Standing().plant
    for _ in range(50):
        standing.driven.step(standing.command())
        bare.step(standing.command())
    np.testing.assert_array_equal(standing.driven.measure().qpos, bare.measure().qpos)
    np.testing.assert_array_equal(standing.driven.measure(bare.measure()).qpos, bare.measure().qpos)


def test_drives_hear_of_a_command_as_many_cycles_later_as_it_is_late(standing: Standing) -> None:
    commands = [standing.command()] * 5 + [standing.command(torque=2.0)] * 10
    whole = Standing().torques(commands)
    standing.driven.alter(delay=0.003)
    late = standing.torques(commands)
    assert next(index for index, torque in enumerate(whole) if torque > 1.0) == 5
    assert next(index for index, torque in enumerate(late) if torque > 1.0) == 8


def test_nothing_that_was_under_way_arrives_in_the_next_run(standing: Standing) -> None:
    standing.driven.alter(delay=0.003)
    standing.torques([standing.command(torque=2.0)] * 5)
    standing.plant.place(standing.plant.data.qpos.copy())
    standing.driven.alter(delay=0.003)
    assert max(standing.torques([standing.command()] * 5)) < 1.0


def test_an_encoder_that_is_off_shows_it_and_holds_its_joint_where_it_is_not(standing: Standing) -> None:
    errors = np.zeros_like(standing.joints)
    errors[-1] = ERROR
    standing.driven.alter(encoders=errors)
    for _ in range(400):
        standing.driven.step(standing.command())
    true, shown = standing.plant.measure().qpos[7:], standing.driven.measure().qpos[7:]
    np.testing.assert_allclose(shown - true, errors)
    untouched = Standing()
    for _ in range(400):
        untouched.driven.step(untouched.command())
    moved = true - untouched.plant.measure().qpos[7:]
    assert moved[-1] == pytest.approx(-ERROR, rel=0.1)


def test_what_it_is_told_is_left_as_it_was(standing: Standing) -> None:
    errors = np.full_like(standing.joints, ERROR)
    standing.driven.alter(encoders=errors)
    command = standing.command(standing.joints.copy())
    standing.driven.step(command)
    np.testing.assert_array_equal(command.position, standing.joints)
