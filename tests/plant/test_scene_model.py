"""What physics runs on is the scene that is drawn, without what is only drawn."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.messages import Array
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import load_scene
from humanoid_bt.plant.scene_model import FLOOR_CONTACTS, physics_model, scene_model
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel

SIM = Path(__file__).resolve().parents[2] / "sim"
SCENE = """\
format: 1
name: bench
objects:
  ball: {shape: ball, size: [0.05], position: [0.5, 0.0, 1.0]}
  bench: {shape: box, size: [0.4, 0.4, 0.6], position: [0.0, 0.45, 0.7], solid: true}
"""
STEPS = 200
COUNTS = {"body": "nbody", "joint": "njnt", "site": "nsite", "actuator": "nu"}


@pytest.fixture(scope="module")
def robot() -> tuple[RobotModel, Array]:
    return load_robot(SIM / "humanoid" / "robot.yaml")


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    file = tmp_path_factory.mktemp("scenes") / "bench.yaml"
    file.write_text(SCENE)
    return Scene(load_scene(file), 0)


def moved(model: mujoco.MjModel, start: Array, robot: RobotModel) -> mujoco.MjData:
    """Return where the robot is after a while in which its drives hold it, and what it stands beside."""
    data = mujoco.MjData(model)
    data.qpos[: len(start)] = start
    data.ctrl[:] = robot.stiffness * start[BASE_COORDINATES:]
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    return data


def test_physics_moves_as_the_whole_scene_does_to_the_bit(robot: tuple[RobotModel, Array], scene: Scene) -> None:
    model, start = robot
    whole, physics = scene_model(model, scene), physics_model(model, scene)
    seen, ours = moved(whole, start, model), moved(physics, start, model)
    assert np.abs(ours.qvel).max() > 1e-3, "nothing moves"
    assert np.array_equal(ours.qpos, seen.qpos)
    assert np.array_equal(ours.qvel, seen.qvel)
    assert ours.ncon == seen.ncon > 0


def test_physics_has_everything_at_the_same_place_but_what_is_only_drawn(
    robot: tuple[RobotModel, Array], scene: Scene
) -> None:
    whole, physics = scene_model(robot[0], scene), physics_model(robot[0], scene)
    for kind, count in COUNTS.items():
        ours, theirs = ([getattr(of, kind)(i).name for i in range(getattr(of, count))] for of in (physics, whole))
        assert ours == theirs
    assert np.array_equal(physics.body_mass, whole.body_mass)
    assert np.array_equal(physics.body_inertia, whole.body_inertia)
    touching = (whole.geom_contype | whole.geom_conaffinity) > 0
    assert physics.ngeom == touching.sum() < whole.ngeom
    assert np.array_equal(physics.geom_bodyid, whole.geom_bodyid[touching])


def test_only_contacts_with_the_floor_are_counted(robot: tuple[RobotModel, Array], scene: Scene) -> None:
    model, start = robot
    physics = physics_model(model, scene)
    data = moved(physics, start, model)
    bodies = physics.geom_bodyid[data.contact.geom]
    with_floor = int((bodies == 0).any(axis=1).sum())
    assert 0 < with_floor < data.ncon, "it does not touch both"
    assert data.sensordata[physics.sensor(FLOOR_CONTACTS).adr[0]] == with_floor
