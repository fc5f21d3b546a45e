"""Where feet of every shape touch the floor."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.footprint import footprint
from humanoid_bt.robot.model import RobotModel

BUILTIN = Path(__file__).resolve().parents[2] / "sim" / "humanoid"
WEDGE = """
<asset><mesh name="wedge" vertex="-.08 -.05 -.07  .12 -.05 -.07  -.08 .05 -.07  .12 .05 -.07  0 0 0"/></asset>
"""


@pytest.mark.parametrize(
    ("geom", "centre", "half"),
    [
        ('type="box" size="0.1 0.05 0.02" pos="0.03 0 -0.04"', [0.03, 0, -0.06], [0.1, 0.05]),
        ('type="capsule" size="0.02 0.1" pos="0.03 0 -0.04" euler="0 1.5708 0"', [0.03, 0, -0.06], [0.1, 0]),
        ('type="sphere" size="0.03" pos="0.02 0.01 -0.05"', [0.02, 0.01, -0.08], [0, 0]),
        ('type="cylinder" size="0.06 0.02" pos="0 0 -0.04"', [0, 0, -0.06], [0.06, 0.06]),
        ('type="ellipsoid" size="0.1 0.05 0.03" pos="0.01 0 -0.03"', [0.01, 0, -0.06], [0, 0]),
        ('type="mesh" mesh="wedge"', [0.02, 0, -0.07], [0.1, 0.05]),
    ],
)
def test_the_lowest_points_of_a_foot_are_its_sole(
    tmp_path: Path, geom: str, centre: list[float], half: list[float]
) -> None:
    text = (BUILTIN / "humanoid.xml").read_text()
    own = re.search(r'<geom name="left_foot".*?/>', text, re.DOTALL)
    assert own is not None
    text = text.replace(own[0], f'<geom mass="1" contype="1" conaffinity="1" {geom}/>')
    (tmp_path / "humanoid.xml").write_text(text.replace("<worldbody>", f"{WEDGE}<worldbody>"))
    (tmp_path / "robot.yaml").write_text((BUILTIN / "robot.yaml").read_text())
    found = footprint(RobotModel(load_robot_config(tmp_path / "robot.yaml")), "left")
    assert found is not None
    np.testing.assert_allclose(found.centre, centre, atol=2e-3)
    np.testing.assert_allclose(found.half, half, atol=2e-3)


def test_a_foot_that_nothing_can_touch_has_none() -> None:
    robot = RobotModel(load_robot_config(BUILTIN / "robot.yaml"))
    assert footprint(robot, "left") is not None
    robot.model.geom_contype[:] = robot.model.geom_conaffinity[:] = 0
    assert footprint(robot, "left") is None
