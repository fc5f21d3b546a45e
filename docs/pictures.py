"""Takes the pictures of the docs from runs of the robot: ``python docs/pictures.py [PICTURE ...]``.

They are view, demo, reach, walk and coverage; without arguments it takes all of them. It needs a software renderer
where there is no graphics card (Debian: mesa-vulkan-drivers, libegl1, libgl1-mesa-dri), for the last one chromium, and
some minutes. Not part of ``make docs``: pictures differ a little from one machine to the next.
"""

from __future__ import annotations

import argparse
import io
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont
from rerun.experimental import ViewerClient

from humanoid_bt.core.messages import Array, State
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.floor import FLOOR
from humanoid_bt.plant.scene import LAMP, Scene
from humanoid_bt.plant.scene_config import ObjectConfig, SceneConfig
from humanoid_bt.plant.scene_model import scene_model
from humanoid_bt.record.sinks import LOOPBACK
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.session.listener import Listener
from humanoid_bt.session.run import run
from humanoid_bt.session.session import Session
from humanoid_bt.testing.coverage import counting, coverage_in, tree_coverage, tree_files
from humanoid_bt.testing.coverage_page import page
from humanoid_bt.testing.rig import Rig

IMAGES = Path(__file__).parent / "images"

VIEW_TIME = 8.9  # s into the demo: the hand is on its way to the ball
VIEW_PORT = 9911
VIEW_SIZE = (1920, 1080)  # of the viewer's window
VIEW_PART = (960, 36, 1920, 1050)  # of it: a page is about 880 wide, and what is written has to be read there

DEMO_SIZE = (880, 495)
DEMO_FRAME = 4  # ticks from one frame to the next
DEMO_END = 2.5  # s that the last frame stays
DEMO_QUALITY = 62
SWAY = 75  # ticks over which the camera averages where the robot is
SOLID, GHOST = (0.97, 0.5, 0.08, 1.0), (0.85, 0.88, 0.92, 0.45)  # the ball as it is, and where it is hidden
BAR = 58  # pixels of the caption
STATUS_COLORS = {"running": (92, 176, 255), "success": (92, 206, 120)}

BALL = (0.40, -0.16, 0.95)  # m
REACH_SIZE = (1000, 750)
WALK_SIZE = (196, 400)  # of each of its pictures
WALK_FROM, WALK_EVERY, WALK_COUNT = 151, 5, 9  # ticks, at full speed: two steps and a little
COVERAGE_SIZE = (1180, 1130)


# ---- the viewer ------------------------------------------------------------------------------------------------------


def view(path: Path) -> None:
    """Take a picture of the demo's recording in the viewer."""
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "fetch.rrd"
        run("fetch", workspace=builtin_root(), record=recording)
        with _viewer() as viewer:
            viewer.open(str(recording))
            time.sleep(2)
            viewer.set_time("sim_time", duration=VIEW_TIME, play_state="paused")
            time.sleep(2)
            shot = Image.open(io.BytesIO(viewer.take_screenshot()))
    shot.convert("RGB").crop(VIEW_PART).save(path, optimize=True)


@contextmanager
def _viewer() -> Iterator[ViewerClient]:
    """Run the viewer without a display, for this machine only."""
    program = str(Path(sys.executable).parent / "rerun")
    size = "x".join(map(str, VIEW_SIZE))
    options = [
        "--headless",
        "--hide-welcome-screen",
        "--bind",
        LOOPBACK,
        "--port",
        str(VIEW_PORT),
        "--window-size",
        size,
    ]
    process = subprocess.Popen([program, *options], start_new_session=True)  # it starts the viewer as a child
    try:
        time.sleep(3)
        yield ViewerClient.connect(f"rerun+http://{LOOPBACK}:{VIEW_PORT}/proxy")
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


# ---- the demo, animated ----------------------------------------------------------------------------------------------


class _Moment(NamedTuple):
    """What one frame shows."""

    state: State
    node: str
    status: str
    feedback: str


class _Caption(Listener):
    """Keeps which node runs, and what it says."""

    def __init__(self) -> None:
        self.node = self.feedback = ""

    def progress(self, time: float, running: str) -> None:
        """Take the deepest running node and what it says."""
        self.node, _, self.feedback = running.partition(": ")


def demo(file: Path) -> None:
    """Animate the demo, rendered by MuJoCo, with the node that runs as a caption."""
    caption = _Caption()
    moments: list[_Moment] = []
    with Session("fetch", workspace=builtin_root(), listener=caption) as session:
        while session.step():
            moments.append(_Moment(session.state, caption.node, "running", caption.feedback))
    node, _, feedback = session.report.reason.partition(": ")
    moments.append(_Moment(session.state, node, session.report.outcome, feedback))
    scene = session.engine.scene
    model = scene_model(session.engine.robot, scene)
    _furnish(model)
    path = _camera_path([moment.state for moment in moments], scene.object_position("ball", 0.0))
    shown = [*range(0, len(moments) - 1, DEMO_FRAME), len(moments) - 1]
    width, height = DEMO_SIZE
    frames: list[Image.Image] = []
    with mujoco.Renderer(model, height, width) as renderer:
        renderer.scene.flags[mujoco.mjtRndFlag.mjRND_FOG] = True
        for index in shown:
            moment = moments[index]
            hidden = scene.hidden("ball", moment.state.time)
            model.geom("object_ball").rgba[:] = GHOST if hidden else SOLID
            middle, distance, heading = path[index]
            camera = _camera(middle, distance, azimuth=114 + np.degrees(heading), elevation=-9)
            image = _render(renderer, model, moment.state, camera)
            frames.append(_captioned(image, moment, "the ball is hidden" if hidden else ""))
    durations = [round(1000 * 0.02 * DEMO_FRAME)] * (len(frames) - 1) + [round(1000 * DEMO_END)]
    frames[0].save(
        file, save_all=True, append_images=frames[1:], duration=durations, loop=0, quality=DEMO_QUALITY, method=4
    )


def _camera_path(states: list[State], ball: Array) -> list[tuple[Array, float, float]]:
    """Return for each tick where the camera looks, from how far, and the robot's heading, all without swaying."""
    ways = np.array([[*state.base_position, state.stance[2]] for state in states])
    ways = np.pad(ways, ((SWAY, SWAY), (0, 0)), mode="edge")
    window = np.hanning(2 * SWAY + 1)
    smooth = np.stack([np.convolve(way, window / window.sum(), mode="valid") for way in ways.T], axis=-1)
    path = []
    for *robot, heading in smooth:
        x, y, _ = (np.array(robot) + ball) / 2
        path.append((np.array([x, y, 0.58]), 1.8 + 0.65 * np.linalg.norm((robot - ball)[:2]), heading))
    return path


def _captioned(image: Image.Image, moment: _Moment, remark: str) -> Image.Image:
    width, height = image.size
    shade = Image.new("RGBA", image.size)
    ImageDraw.Draw(shade).rectangle((0, height - BAR, width, height), fill=(13, 17, 23, 205))
    image = Image.alpha_composite(image.convert("RGBA"), shade).convert("RGB")
    draw = ImageDraw.Draw(image)
    line = height - BAR / 2
    large, small = ImageFont.load_default(28), ImageFont.load_default(22)
    draw.text((22, line), moment.node, font=large, fill=(255, 255, 255), anchor="lm")
    x = 22 + draw.textlength(moment.node, font=large) + 18
    draw.text((x, line), moment.status, font=large, fill=STATUS_COLORS[moment.status], anchor="lm")
    x += draw.textlength(moment.status, font=large) + 22
    draw.text((x, line), moment.feedback, font=small, fill=(200, 206, 214), anchor="lm")
    draw.text((width - 22, line), f"{moment.state.time:.1f} s", font=small, fill=(200, 206, 214), anchor="rm")
    if remark:
        draw.text((width - 22, 22), remark, font=large, fill=(180, 60, 30), anchor="rt")
    return image


# ---- the robot -------------------------------------------------------------------------------------------------------


def reach(path: Path) -> None:
    """Take a picture of the robot with its hand at a ball, rendered by MuJoCo."""
    workspace = Workspace(builtin_root())
    result = Rig(workspace).run("reach", target=BALL)
    if not result.succeeded:
        raise RuntimeError(result.feedback)
    ball = ObjectConfig(shape="ball", size=[0.08], position=BALL, stand=True)
    scene = Scene(SceneConfig(format=1, name="reach", objects={"ball": ball}), seed=0)
    model = scene_model(RobotModel(load_robot_config(workspace.find_robot("humanoid"))), scene)
    _furnish(model)
    width, height = REACH_SIZE
    with mujoco.Renderer(model, height, width) as renderer:
        renderer.scene.flags[mujoco.mjtRndFlag.mjRND_FOG] = True
        camera = _camera(np.array([0.15, -0.02, 0.72]), 1.9, azimuth=112, elevation=-12)
        _render(renderer, model, result.states[-1], camera).save(path, optimize=True)


def walk(path: Path) -> None:
    """Take a series of pictures of two steps, a tenth of a second apart, from the right, rendered by MuJoCo."""
    workspace = Workspace(builtin_root())
    result = Rig(workspace).run("walk_to", x=3.0, y=0.0, heading=0.0)
    if not result.succeeded:
        raise RuntimeError(result.feedback)
    scene = Scene(SceneConfig(format=1, name="walk"), seed=0)
    model = scene_model(RobotModel(load_robot_config(workspace.find_robot("humanoid"))), scene)
    _furnish(model)
    width, height = WALK_SIZE
    series = Image.new("RGB", (width * WALK_COUNT, height))
    with mujoco.Renderer(model, height, width) as renderer:
        for number in range(WALK_COUNT):
            state = result.states[WALK_FROM + number * WALK_EVERY]
            camera = _camera(np.array([state.base_position[0], 0.0, 0.64]), 2.15, azimuth=90, elevation=-3)
            series.paste(_render(renderer, model, state, camera), (width * number, 0))
    series.quantize(256).save(path, optimize=True)


def _furnish(model: mujoco.MjModel) -> None:
    """Give the scene a floor without end, a soft horizon, and a light that pictures well."""
    quality, visual = model.vis.quality, model.vis
    quality.offsamples, quality.shadowsize = 4, 4096
    visual.map.fogstart, visual.map.fogend = 3.5, 11
    visual.rgba.fog[:] = [0.80, 0.86, 0.92, 1]
    visual.headlight.ambient[:], visual.headlight.diffuse[:], visual.headlight.specular[:] = 0.34, 0.28, 0.1
    lamp, floor = model.light(LAMP), model.mat(FLOOR)
    lamp.pos[:], lamp.dir[:], lamp.diffuse[:] = [0.2, -2.5, 6], [0.12, 0.5, -1], 0.72
    lamp.cutoff[:], lamp.exponent[:] = 80, 0.5
    floor.rgba[:], floor.reflectance[:] = [1.12, 1.12, 1.15, 1], 0.1
    model.geom(FLOOR).size[:2] = 0  # MuJoCo draws a plane of no size to the horizon


def _camera(middle: Array, distance: float, *, azimuth: float, elevation: float) -> mujoco.MjvCamera:
    camera = mujoco.MjvCamera()
    camera.lookat[:] = middle
    camera.distance, camera.azimuth, camera.elevation = distance, azimuth, elevation
    return camera


def _render(renderer: mujoco.Renderer, model: mujoco.MjModel, state: State, camera: mujoco.MjvCamera) -> Image.Image:
    data = mujoco.MjData(model)
    data.qpos[:] = np.concatenate([state.base_position, state.base_quaternion, state.joint_positions])
    mujoco.mj_forward(model, data)
    renderer.update_scene(data, camera)
    return Image.fromarray(renderer.render())


# ---- tree coverage ---------------------------------------------------------------------------------------------------


def coverage(path: Path) -> None:
    """Take a picture of the page of a run of the demo, in a Chromium without a display."""
    with counting() as folder:
        run("fetch", workspace=builtin_root())
        page_file = folder / "coverage.html"
        os.chdir(builtin_root())
        files = tree_files(["fetch", "stand"], builtin_root())
        page_file.write_text(page(tree_coverage(coverage_in(folder), files)), "utf-8")
        size = f"--window-size={COVERAGE_SIZE[0]},{COVERAGE_SIZE[1]}"
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", size, f"--screenshot={path}"]
        subprocess.run(["chromium", *options, page_file.as_uri()], check=True, stderr=subprocess.DEVNULL)
    shot = Image.open(path).convert("RGB")
    shot.quantize(128).save(path, optimize=True)


PICTURES = {
    "view": (view, "view.png"),
    "demo": (demo, "demo.webp"),
    "reach": (reach, "reach.png"),
    "walk": (walk, "walk.png"),
    "coverage": (coverage, "coverage.png"),
}


def main() -> None:
    """Take the pictures that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("pictures", nargs="*", metavar="PICTURE", help=f"one of {', '.join(PICTURES)}; default: all")
    parser.add_argument("--out", type=Path, default=IMAGES, metavar="FOLDER", help="where to; default: docs/images")
    arguments = parser.parse_args()
    names = arguments.pictures or list(PICTURES)
    if unknown := [name for name in names if name not in PICTURES]:
        parser.error(f"there is no picture {unknown[0]!r}; valid: {', '.join(PICTURES)}")
    folder: Path = arguments.out.absolute()
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        take, file = PICTURES[name]
        take(folder / file)


if __name__ == "__main__":
    main()
