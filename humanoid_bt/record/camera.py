"""The head camera's pictures in the recording: what perception can see, five times a second."""

from __future__ import annotations

import math
import os
from collections.abc import Container, Mapping
from typing import Any

import mujoco
import numpy as np
import rerun as rr

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array, State
from humanoid_bt.plant.opengl import INSTALL
from humanoid_bt.plant.rendering import Setup, Shot, View
from humanoid_bt.record.columns import send, xyzw
from humanoid_bt.record.photographer import Photographer
from humanoid_bt.record.scene_view import OBJECT_PREFIX, WORLD
from humanoid_bt.record.subject import Wanted

CAMERA = "camera"
"""Entity of the pictures; also the name of the camera's frame."""

_PLANE = f"{CAMERA}_image"
_WHY = f"{CAMERA}/why"
_PERIOD = 0.2  # s
_SLACK = 1e-6  # times are sums of periods
_SLOWEST = (
    0.05  # s of CPU time that a picture may take unless insisted on: a quarter of a core, at the pace of the clock
)


class HeadCamera:
    """Writes pictures, and from where they were taken.

    Args:
        model: the whole scene.
        view: what is in the picture.
        wanted: True to insist: on every picture, however long it takes, or to say why there is none.
        busy_cores: how many cores the run itself needs.

    Raises:
        UserError: it is insisted on, and there is no OpenGL.
    """

    def __init__(self, model: mujoco.MjModel, view: View, wanted: Wanted, busy_cores: int) -> None:
        self._view = view
        self._last = -math.inf
        self._without: list[tuple[Shot, bytes]] = []
        self._photographer: Photographer | None = None
        self._told = wanted is False  # nobody wonders
        self._why, self._written = "" if wanted else "it is switched off", ""
        if wanted == "auto" and _cores() <= busy_cores:
            self._why = "the run leaves no core for it"
        elif wanted:
            setup = Setup(model, view)
            self._photographer = Photographer(setup, math.inf if wanted is True else _SLOWEST)
        if wanted is True and self._photographer is not None:
            self._photographer.wait_until_ready()
            if why := self._photographer.why:
                self._photographer.finish()
                hint = f"{INSTALL}; or do without the camera"
                raise UserError(f"there is no picture of the head camera: {why}", hint=hint)

    @property
    def why_none(self) -> str:
        """Why there are no pictures, "" if there are or may be."""
        return self._why or (self._photographer.why if self._photographer else "")

    def take_news(self) -> str:
        """Return why there are no pictures, once, and only if nobody has switched it off; else ""."""
        why = "" if self._told else self.why_none
        self._told = self._told or bool(why)
        return why

    def log_static(self, stream: Any) -> None:
        """Write where the picture is in the world, so that percepts are drawn into it."""
        width, height = self._view.size
        pinhole = rr.Pinhole(
            resolution=[width, height],
            focal_length=self._view.focal,
            camera_xyz=rr.ViewCoordinates.FLU,
            parent_frame=CAMERA,
            child_frame=_PLANE,
        )
        stream.log(CAMERA, pinhole, rr.CoordinateFrame(_PLANE), static=True)
        look = rr.Points2D.from_fields(positions=[[width / 2, height / 2]], radii=[0.0], show_labels=True)
        stream.log(_WHY, rr.CoordinateFrame(_PLANE), look, static=True)

    def add(self, state: State, objects: Mapping[str, Array], hidden: Container[str]) -> None:
        """Have a picture taken of a state, if it is time for one."""
        if state.time - self._last < _PERIOD - _SLACK:
            return
        self._last = state.time
        shot = Shot(
            state.time,
            np.concatenate([state.base_position, state.base_quaternion, state.joint_positions]),
            state.gaze_position,
            state.gaze_direction,
            {OBJECT_PREFIX + name: position for name, position in objects.items()},
            tuple(OBJECT_PREFIX + name for name in objects if name in hidden),
        )
        if self._photographer is None or self._photographer.why:
            self._without.append((shot, b""))
        else:
            self._photographer.order(shot)

    def flush(self, stream: Any) -> None:
        """Write the pictures taken since the last flush and from where; without pictures where they would be from."""
        if self.why_none != self._written:
            self._written = self.why_none
            stream.log(_WHY, rr.Points2D.from_fields(labels=[f"no picture: {self._written}"]), static=True)
        taken = self._photographer.collect() if self._photographer else []
        taken, self._without = taken + self._without, []
        if not taken:
            return
        shots = [shot for shot, _ in taken]
        poses = rr.Transform3D.columns(
            translation=np.array([shot.position for shot in shots]),
            quaternion=xyzw(np.array([_turn(shot.direction) for shot in shots])),
            parent_frame=[WORLD] * len(shots),
            child_frame=[CAMERA] * len(shots),
        )
        send(stream, CAMERA, [shot.time for shot in shots], poses)
        if pictures := [(shot.time, np.frombuffer(jpeg, dtype=np.uint8)) for shot, jpeg in taken if jpeg]:
            times, blobs = zip(*pictures, strict=True)
            images = rr.EncodedImage.columns(blob=list(blobs), media_type=["image/jpeg"] * len(blobs))
            send(stream, CAMERA, times, images)

    @property
    def patience(self) -> float:
        """How long :meth:`finish` waits at most [s]."""
        return self._photographer.patience if self._photographer is not None else 0.0

    def finish(self) -> None:
        """Wait a little for pictures that are not there yet; there will be no others."""
        if self._photographer is not None:
            self._photographer.finish()


def _cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _turn(direction: Array) -> Array:
    """Return the rotation of a level camera that looks in a direction, wxyz."""
    x, y, z = direction
    yaw, down = math.atan2(y, x) / 2, -math.atan2(z, math.hypot(x, y)) / 2
    turn = np.zeros(4)
    about_z = np.array([math.cos(yaw), 0.0, 0.0, math.sin(yaw)])
    mujoco.mju_mulQuat(turn, about_z, np.array([math.cos(down), 0.0, math.sin(down), 0.0]))
    return turn
