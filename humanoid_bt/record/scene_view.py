"""The robot and the scene: every geom once, then only the poses of the bodies that move."""

from __future__ import annotations

import copy
from collections.abc import Container, Mapping, Sequence
from functools import partial
from typing import Any

import mujoco
import numpy as np
import pyarrow as pa
import rerun as rr

from humanoid_bt.core.errors import HumanoidBtError, nearest
from humanoid_bt.core.messages import Array, State
from humanoid_bt.record import geoms
from humanoid_bt.record.batch import Batch
from humanoid_bt.record.columns import entity, send, xyzw

WORLD = "world"
"""Root entity of the 3D view, and the name of its frame."""

POSES = "poses"
"""The one entity that carries the poses of all moving bodies."""

_BASE_HEIGHTS = (0.4, 1.2)  # believable ones [m]: a model may also leave its base at the origin
TRUTH = f"{WORLD}/truth"
OBJECT_PREFIX = "object_"
"""What the names of bodies that are scene objects begin with."""


class SceneView:
    """Draws a model's bodies at recorded states.

    Works on copies of the model and its data, so that nothing it does reaches the simulation.

    Args:
        model: the whole scene; the robot's qpos comes first: free base, then joints.
        joint_count: number of the robot's joints after the base.
        base: body with the robot's free joint.

    Attributes:
        base_height: of the standing robot, as far as the model tells [m].
        heights: object name -> lowest and highest point of it, relative to its position [m].
    """

    def __init__(self, model: mujoco.MjModel, joint_count: int, base: str) -> None:
        self._model = copy.copy(model)
        self._data = mujoco.MjData(self._model)
        self._joint_count = joint_count
        self.base_height = float(np.clip(model.body(base).pos[2], *_BASE_HEIGHTS))
        names = {body: _body_name(model, body) for body in range(1, model.nbody)}
        stands = {body for body in names if model.body_weldid[body] == 0}
        self._objects = {
            name.removeprefix(OBJECT_PREFIX): body
            for body, name in names.items()
            if body in stands and name.startswith(OBJECT_PREFIX)
        }
        self.heights = {name: geoms.height(model, body) for name, body in self._objects.items()}
        roots = (names.keys() - stands) | set(self._objects.values())
        self._moving = np.array([body for body in names if self._hangs_on(body, roots)], dtype=int)
        self._frames = pa.array([names[body] for body in self._moving], pa.string())
        self._poses: Batch[tuple[float, Array, Array]] = Batch("the robot and the scene")
        self._looks: dict[str, list[tuple[str, int, Any]]] = {name: [] for name in self._objects}
        self._hidden: dict[str, bool] = {}
        self._hidings: Batch[tuple[float, str, bool]] = Batch("what is hidden")
        self._base = model.body(base).id
        self._truths: Batch[tuple[float, Array]] = Batch("where the base really is")

    def log_static(self, stream: Any) -> None:
        """Write the geoms: those of moving bodies in their bodies' frames, the others in the world's.

        The look of objects comes later: it changes, and what is static can not.
        """
        model, data = self._model, self._data
        mujoco.mj_kinematics(model, data)
        stream.log(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, rr.CoordinateFrame(WORLD), static=True)
        moving = {int(body) for body in self._moving}
        objects = {body: name for name, body in self._objects.items()}
        for geom in range(model.ngeom):
            drawn = geoms.shape(model, geom) if geoms.is_drawn(model, geom) else None
            if drawn is None:
                continue
            body = int(model.geom_bodyid[geom])
            if body in moving:
                position, quaternion = model.geom_pos[geom], model.geom_quat[geom]
            else:
                position, quaternion = data.geom_xpos[geom], np.zeros(4)
                mujoco.mju_mat2Quat(quaternion, data.geom_xmat[geom])
            path = f"{self._folder(body)}/{entity(model.geom(geom).name or f'geom_{geom}')}"
            pose = rr.InstancePoses3D(translations=[position], quaternions=[rr.Quaternion(xyzw=xyzw(quaternion))])
            written = [drawn, pose, rr.CoordinateFrame(_body_name(model, body) if body in moving else WORLD)]
            if body in objects:
                self._looks[objects[body]].append((path, geom, type(drawn)))
            elif isinstance(drawn, geoms.PRIMITIVES):
                written.append(type(drawn).from_fields(**geoms.look(model, geom)))
            stream.log(path, *written, static=True)
            if body == self._base and isinstance(drawn, geoms.PRIMITIVES):
                outline = type(drawn).from_fields(**geoms.look(model, geom, hidden=True))
                written = [drawn, pose, outline, rr.CoordinateFrame(TRUTH)]
                stream.log(path.replace(self._folder(body), TRUTH), *written, static=True)

    def add_truth(self, time: float, pose: Array) -> None:
        """Show where the base really is, as an outline.

        Args:
            time: [s].
            pose: world frame, shape (7,).
        """
        self._truths.append((time, pose))

    def add(self, state: State, objects: Mapping[str, Array], hidden: Container[str]) -> None:
        """Compute the bodies' poses in one state.

        Args:
            state: base pose and joint positions.
            objects: object name -> position, world frame, shape (3,) [m].
            hidden: names of those that perception cannot see.

        Raises:
            HumanoidBtError: the scene has no object of that name.
        """
        model, data = self._model, self._data
        for name, position in objects.items():
            body = self._objects.get(name)
            if body is None:
                raise HumanoidBtError(f"the scene has no object {name!r}; {nearest(name, self._objects)}")
            model.body_pos[body] = position
        # the recorder's own copy of the scene, for kinematics only: the simulation is elsewhere
        data.qpos[:3] = state.base_position
        data.qpos[3:7] = state.base_quaternion
        data.qpos[7 : 7 + self._joint_count] = state.joint_positions
        mujoco.mj_kinematics(model, data)
        for name in self._objects:
            if self._hidden.get(name) is not (now := name in hidden):
                self._hidden[name] = now
                self._hidings.append((state.time, name, now))
        self._poses.append((state.time, data.xpos.copy(), data.xquat.copy()))

    def flush(self, stream: Any) -> None:
        """Write the poses and looks added since the last flush."""
        self._poses.draw(partial(self._draw_poses, stream))
        self._truths.draw(partial(_draw_truths, stream))
        self._hidings.draw(partial(self._draw_hidings, stream))

    def _draw_poses(self, stream: Any, poses: Sequence[tuple[float, Array, Array]]) -> None:
        times, positions, quaternions = zip(*poses, strict=True)
        rows, bodies = len(times), len(self._moving)
        if not bodies:
            return
        columns = rr.Transform3D.columns(
            translation=np.array(positions)[:, self._moving].reshape(-1, 3),
            quaternion=xyzw(np.array(quaternions)[:, self._moving].reshape(-1, 4)),
            parent_frame=pa.repeat(WORLD, rows * bodies),
            child_frame=pa.concat_arrays([self._frames] * rows),
        )
        send(stream, POSES, np.repeat(times, bodies), columns)

    def _draw_hidings(self, stream: Any, hidings: Sequence[tuple[float, str, bool]]) -> None:
        for time, name, hidden in hidings:
            for path, geom, kind in self._looks[name]:
                look = kind.columns(**geoms.look(self._model, geom, hidden=hidden))
                send(stream, path, [time], look, lasting=True)

    def _hangs_on(self, body: int, roots: set[int]) -> bool:
        while body:
            if body in roots:
                return True
            body = int(self._model.body_parentid[body])
        return False

    def _folder(self, body: int) -> str:
        if not body:
            return f"{WORLD}/scene"
        root = int(self._model.body_rootid[body])
        part = "robot" if self._model.body_weldid[root] else "scene"
        return entity(WORLD, part, _body_name(self._model, body))


def _draw_truths(stream: Any, truths: Sequence[tuple[float, Array]]) -> None:
    times, poses = zip(*truths, strict=True)
    true, rows = np.array(poses), len(times)
    columns = rr.Transform3D.columns(
        translation=true[:, :3],
        quaternion=xyzw(true[:, 3:]),
        parent_frame=[WORLD] * rows,
        child_frame=[TRUTH] * rows,
    )
    send(stream, TRUTH, times, columns)


def _body_name(model: mujoco.MjModel, body: int) -> str:
    return model.body(body).name or f"body_{body}"
