"""The shape of a robot as capsules."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.capsules import STICKS_OUT, Capsule, capsules
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from tests.robot.test_model import Edit, edit, robot

__all__ = ["edit", "robot"]

TETRAHEDRON = "0 0 0  0.3 0 0  0 0.2 0  0 0 0.1"


def of(robot: RobotModel, body: str) -> list[Capsule]:
    return [capsule for capsule in capsules(robot) if robot.model.body(capsule.body).name == body]


def outside(capsules: list[Capsule], points: Array) -> Array:
    """Return how far points, in the body's frame, stick out of all capsules, shape (n,) [m]."""
    found = []
    for capsule in capsules:
        start, way = capsule.ends[0], capsule.ends[1] - capsule.ends[0]
        share = np.clip((points - start) @ way / max(way @ way, 1e-12), 0, 1)
        found.append(np.linalg.norm(points - start - share[:, None] * way, axis=1) - capsule.radius)
    return np.min(found, axis=0)


def test_a_capsule_stays_what_it_is(robot: RobotModel) -> None:
    (thigh,) = of(robot, "left_thigh")
    np.testing.assert_allclose(np.sort(thigh.ends[:, 2]), [-0.26, -0.04])
    assert thigh.radius == pytest.approx(0.052)


def test_a_box_is_covered_and_not_much_more(robot: RobotModel) -> None:
    found = of(robot, "left_hand")
    corners = np.array(np.meshgrid([-0.038, 0.038], [-0.022, 0.014], [-0.145, -0.035])).reshape(3, -1).T
    assert outside(found, corners).max() <= STICKS_OUT + 1e-9
    for capsule in found:
        assert (np.abs(capsule.ends[:, 1] + 0.004) + capsule.radius).max() < 0.018 + 0.015


@pytest.mark.parametrize(
    "shape",
    [
        'type="cylinder" size="0.04 0.1"',
        'type="ellipsoid" size="0.05 0.08 0.12"',
        'type="box" size="0.01 0.05 0.12"',
        'type="mesh" mesh="wedge"',
    ],
)
def test_every_kind_of_shape_is_covered(edit: Edit, tmp_path: Path, shape: str) -> None:
    old = '<geom name="head" class="solid" type="sphere" size="0.088" pos="0.01 0 0.07" mass="1.8"/>'
    edit(
        "humanoid.xml",
        old,
        f'<geom name="head" class="solid" {shape} quat="1 0.2 0.3 0" pos="0.01 0 0.07" mass="1.8"/>',
    )
    edit("humanoid.xml", "<asset>", f'<asset><mesh name="wedge" vertex="{TETRAHEDRON}"/>')
    robot = RobotModel(load_robot_config(tmp_path / "robot.yaml"))
    model, geom = robot.model, robot.model.geom("head").id
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    head = of(robot, "head")
    numbers = np.random.default_rng(0)
    hits = []
    for _ in range(300):  # rays from far away to points in the shape: where they enter it
        aim = data.geom_xpos[geom] + numbers.normal(size=3) * 0.02
        way = numbers.normal(size=3)
        start = aim - way / np.linalg.norm(way)
        place = model.geom_dataid[geom] >= 0
        ray = mujoco.mj_rayMesh if place else None
        far = (
            ray(model, data, geom, start, aim - start, None)
            if ray
            else mujoco.mju_rayGeom(
                data.geom_xpos[geom],
                data.geom_xmat[geom],
                model.geom_size[geom],
                start,
                aim - start,
                model.geom_type[geom],
                None,
            )
        )
        if far >= 0:
            hits.append(start + far * (aim - start))
    body = model.body("head").id
    local = (np.array(hits) - data.xpos[body]) @ data.xmat[body].reshape(3, 3)
    assert len(local) > 100
    assert outside(head, local).max() <= STICKS_OUT + 0.003  # and what lies between the points that were looked at


def test_capsules_of_the_file_take_the_place_of_the_models_shapes(edit: Edit, tmp_path: Path) -> None:
    section = "collision:\n  capsules:\n    - {body: head, start: [0, 0, 0], end: [0, 0, 10 cm], radius: 9 cm}\n"
    edit("robot.yaml", "gait:", f"{section}gait:")
    robot = RobotModel(load_robot_config(tmp_path / "robot.yaml"))
    (head,) = of(robot, "head")
    np.testing.assert_allclose(head.ends, [[0, 0, 0], [0, 0, 0.1]])
    assert head.radius == 0.09
    assert of(robot, "torso")


def test_a_capsule_of_no_body_is_a_mistake_with_its_place(edit: Edit, tmp_path: Path) -> None:
    section = "collision: {capsules: [{body: haed, start: [0, 0, 0], end: [0, 0, 0], radius: 9 cm}]}\n"
    edit("robot.yaml", "gait:", f"{section}gait:")
    with pytest.raises(UserError, match="the model has no body 'haed'") as raised:
        RobotModel(load_robot_config(tmp_path / "robot.yaml"))
    (problem,) = raised.value.problems
    assert problem.hint == "did you mean 'head'?"
    assert problem.place is not None
    assert problem.place.line
