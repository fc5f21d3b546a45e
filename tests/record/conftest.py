"""A small robot and a small tree to record."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import pytest

from humanoid_bt.core.messages import SIDES
from humanoid_bt.plant.rendering import View
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.sinks import Sinks
from humanoid_bt.record.subject import TreeView
from humanoid_bt.robot.config import DriveConfig, GazeConfig, LegConfig, RobotConfig, SiteConfig, SoleConfig
from humanoid_bt.tree.show import Outline, OutlineNode

JOINTS = ("left_hip", "right_hip", "neck")

_MJCF = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 0.1"/>
    <body name="table" pos="2 0 0.5"><geom name="plate" type="box" size="0.3 0.3 0.02" euler="0 0 90"/></body>
    <body name="object_ball" pos="1 0 1"><geom name="ball" type="sphere" size="0.05"/></body>
    <body name="pelvis" pos="0 0 0.8">
      <freejoint/>
      <geom name="belly" type="capsule" size="0.1 0.1"/>
      <geom name="hull" type="box" size="0.1 0.1 0.1" group="3"/>
      <body name="left_leg" pos="0 0.1 0">
        <joint name="left_hip" axis="0 1 0" range="-60 60"/><geom name="left_thigh" type="cylinder" size="0.05 0.3"/>
      </body>
      <body name="right_leg" pos="0 -0.1 0">
        <joint name="right_hip" axis="0 1 0" range="-60 60"/><geom name="right_thigh" type="ellipsoid" size=".1 .1 .3"/>
      </body>
      <body name="head" pos="0 0 0.4">
        <joint name="neck" axis="0 0 1"/><geom name="skull" type="sphere" size="0.1"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


OUTLINE = Outline(
    "small",
    "",
    (
        OutlineNode("root", "root", "selector", "composite", -1),
        OutlineNode("root/reach", "reach", "reach", "skill", 0, parameters=("target: ball",)),
        OutlineNode("root/ruhig ä", "ruhig ä", "idle", "skill", 0),
    ),
)


@pytest.fixture(scope="session")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(_MJCF)


@pytest.fixture(scope="session")
def config() -> RobotConfig:
    legs = {
        side: LegConfig(
            hip_roll=f"{side}_hip",
            hip_pitch=f"{side}_hip",
            ankle_pitch=f"{side}_hip",
            ankle_roll=f"{side}_hip",
            sole=SiteConfig(body=f"{side}_leg"),
        )
        for side in SIDES
    }
    return RobotConfig(
        format=1,
        name="dummy",
        model="dummy.xml",
        base="pelvis",
        torso="pelvis",
        legs=legs,
        sole=SoleConfig(half_length=0.1, half_width=0.05),
        gaze=GazeConfig(body="head"),
        drives=[DriveConfig(joints=["*"], stiffness=100.0, damping=5.0, torque=50.0)],
        groups={"both legs": ["*_hip"], "arms": ["*_elbow"]},
    )


@pytest.fixture
def record(model: mujoco.MjModel, config: RobotConfig, tmp_path: Path) -> Callable[..., Recorder]:
    """Return a maker of recorders into ``run.rrd``."""

    def make(**changes: Any) -> Recorder:
        sinks = changes.pop("sinks", Sinks(tmp_path / "run.rrd"))
        tree = TreeView(OUTLINE, "root: {selector: []}", "trees/small.yaml")
        info = changes.pop("info", {"seed": "7", "parameters": "a: 1\nb: 2"})
        view = View("head", 1.7, 1.4)
        return Recorder(model, JOINTS, config, tree=tree, sinks=sinks, info=info, camera=view, **changes)

    return make
