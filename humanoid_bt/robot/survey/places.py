"""Palms and eyes: named sites, cameras and links of the model where it has some, else the middle of what is there."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import mujoco
import numpy as np

from humanoid_bt.core.messages import Array
from humanoid_bt.robot.config import RobotConfig, WholeBodyConfig
from humanoid_bt.robot.model import carriers
from humanoid_bt.robot.survey.limbs import Limb, Limbs, Surveyor

_PALM, _EYES = re.compile("palm|grip|hand|wrist|tcp", re.I), re.compile("eye|head|cam|gaze|vision|lidar|mid360", re.I)
_CAMERA = re.compile("(^|_)(eye|camera|d4[0-9]5|realsense|zed)", re.I)  # links, of which a head has others as well
_PALM_SHARE = 0.6  # of the way from the wrist to the finger tips


def palm(surveyor: Surveyor, arm: Limb) -> tuple[Array, str]:
    """Return a palm's position in the hand's frame, shape (3,) [m], and what it is taken from, "" for a guess."""
    model, data = surveyor.model, surveyor.data
    beyond = {arm.body, *(int(model.jnt_bodyid[j]) for j in arm.fingers)}
    if found := _named(surveyor, _PALM, lambda body: bool(beyond & set(carriers(model, body)))):
        return _inside(data, arm.body, found[0]), found[1]
    points = [_inside(data, arm.body, data.xpos[model.jnt_bodyid[j]]) for j in arm.fingers]
    if points:
        return np.asarray(np.mean(points, axis=0)), "the fingers"
    centres = [_inside(data, arm.body, data.geom_xpos[g]) for g in surveyor.geoms(arm.body)]
    sizes = [float(model.geom_rbound[g]) for g in surveyor.geoms(arm.body)]
    if not centres:
        return np.zeros(3), ""
    farthest = max(range(len(centres)), key=lambda i: float(np.linalg.norm(centres[i])) + sizes[i])
    away = float(np.linalg.norm(centres[farthest]))
    reach = away + sizes[farthest]
    return centres[farthest] / max(away, 1e-9) * reach * _PALM_SHARE, ""


def eyes(surveyor: Surveyor, limbs: Limbs) -> tuple[int, Array, str]:
    """Return the body with the eyes, where they are in its frame, shape (3,) [m], and what that is taken from."""
    model, data = surveyor.model, surveyor.data
    body = limbs.head.body if limbs.head else limbs.torso
    if found := _named(surveyor, _EYES, lambda other: model.body_weldid[other] == body):
        return body, _inside(data, body, found[0]), found[1]
    for link in range(body + 1, model.nbody):
        if model.body_weldid[link] == body and _CAMERA.search(model.body(link).name):
            return body, _inside(data, body, data.xpos[link]), f"the model's body {model.body(link).name!r}"
    tops = [(surveyor.seen(data.geom_xpos[g]), float(model.geom_rbound[g])) for g in surveyor.geoms(body)]
    if not tops:
        return body, np.zeros(3), ""
    head = max(tops, key=lambda top: float(top[0][2]) + top[1] / 2)
    ahead = data.xpos[surveyor.base] + data.xmat[surveyor.base].reshape(3, 3) @ (head[0] + [head[1] / 2, 0, 0])
    return body, _inside(data, body, ahead), ""


def looks_down(surveyor: Surveyor, limbs: Limbs, body: int, place: Array) -> float:
    """Return how far eyes that no neck turns down must look down to see what the hands reach [rad].

    That is a thing at the height of the hips, as far ahead as it stands to reach. It may be as low in the picture as
    what no trunk would lean for yet: a trunk that leans is of little help, for a learned walker leans back meanwhile.

    Args:
        surveyor: of the model.
        limbs: the robot's.
        body: which carries the eyes.
        place: where they are in its frame, shape (3,) [m].
    """
    if limbs.head and any(surveyor.turns_about(joint, 1) for joint in limbs.head.joints):
        return 0.0
    data = surveyor.data
    ahead, _, above = surveyor.seen(data.xpos[body] + data.xmat[body].reshape(3, 3) @ place).tolist()
    below = math.atan2(above, RobotConfig.reach_distance - ahead)
    return max(0.0, below - WholeBodyConfig.gaze_below)


def _named(surveyor: Surveyor, name: re.Pattern[str], fits: Callable[[int], bool]) -> tuple[Array, str] | None:
    """Return where a site or a camera with such a name is, world frame, and which; sites first."""
    model, data = surveyor.model, surveyor.data
    for kind, count, of, bodies, places in (
        ("site", model.nsite, model.site, model.site_bodyid, data.site_xpos),
        ("camera", model.ncam, model.camera, model.cam_bodyid, None),
    ):
        for i in range(count):
            if name.search(of(i).name) and fits(int(bodies[i])):
                place = _camera(model, data, i) if places is None else places[i]
                return place, f"the model's {kind} {of(i).name!r}"
    return None


def _camera(model: mujoco.MjModel, data: mujoco.MjData, camera: int) -> Array:
    body = int(model.cam_bodyid[camera])
    return np.asarray(data.xpos[body] + data.xmat[body].reshape(3, 3) @ model.cam_pos[camera])


def _inside(data: mujoco.MjData, body: int, point: Array) -> Array:
    """Return a point of the world in a body's frame, shape (3,) [m]."""
    return np.asarray((point - data.xpos[body]) @ data.xmat[body].reshape(3, 3))
