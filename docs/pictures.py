"""Takes the pictures of the docs from a run of the demo: ``python docs/pictures.py``.

Needs a software renderer where there is no graphics card (Debian: mesa-vulkan-drivers, libegl1, libgl1-mesa-dri) and
Pillow. Not part of ``make docs``: pictures differ a little from one machine to the next.
"""

from __future__ import annotations

import io
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np
from PIL import Image
from rerun.experimental import ViewerClient

from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import ObjectConfig, SceneConfig
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.session.run import run
from humanoid_bt.testing.rig import Rig

IMAGES = Path(__file__).parent / "images"
VIEW_TIME = 11.8  # s into the demo: the hand is on its way to the ball
VIEW_PORT = 9911
VIEW_SIZE = (1600, 870)
MENU = 36  # pixels of the viewer's own menu, which is cut off
BALL = (0.40, -0.16, 0.95)  # m
REACH_SIZE = (1000, 750)


def view(path: Path) -> None:
    """Take a picture of the demo's recording in the viewer."""
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "fetch.rrd"
        run("fetch", workspace=builtin_root(), record=recording)
        program = shutil.which("rerun") or str(Path(sys.executable).parent / "rerun")
        with ViewerClient.spawn(
            headless=True, port=VIEW_PORT, hide_welcome_screen=True, executable_path=program
        ) as viewer:
            viewer.open(str(recording))
            time.sleep(2)
            viewer.set_time("sim_time", duration=VIEW_TIME, play_state="paused")
            time.sleep(2)
            shot = Image.open(io.BytesIO(viewer.take_screenshot()))
    shot = shot.convert("RGB").crop((0, MENU, *shot.size))
    shot.resize(VIEW_SIZE, Image.Resampling.LANCZOS).save(path, optimize=True)


def reach(path: Path) -> None:
    """Take a picture of the robot with its hand at a ball, rendered by MuJoCo."""
    workspace = Workspace(builtin_root())
    result = Rig(workspace).run("reach", target=BALL)
    if not result.succeeded:
        raise RuntimeError(result.feedback)
    state = result.states[-1]
    ball = ObjectConfig(shape="ball", size=[0.08], position=BALL, stand=True)
    scene = Scene(SceneConfig(format=1, name="reach", objects={"ball": ball}), seed=0)
    plant = MujocoPlant(RobotModel(load_robot_config(workspace.find_robot("humanoid"))), scene)
    plant.data.qpos[:] = np.concatenate([state.base_position, state.base_quaternion, state.joint_positions])
    mujoco.mj_forward(plant.model, plant.data)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = (0.15, -0.02, 0.72)
    camera.distance, camera.azimuth, camera.elevation = 1.9, 112, -12
    width, height = REACH_SIZE
    with mujoco.Renderer(plant.model, height, width) as renderer:
        renderer.update_scene(plant.data, camera)
        Image.fromarray(renderer.render()).save(path, optimize=True)


if __name__ == "__main__":
    IMAGES.mkdir(exist_ok=True)
    view(IMAGES / "view.png")
    reach(IMAGES / "reach.png")
