"""What a recording's 3D view shows of robot and scene: shapes of bodies, and where these bodies were."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from humanoid_bt.core.messages import Array
from humanoid_bt.record.reading import files_of
from humanoid_bt.record.rrd import RrdFile
from humanoid_bt.record.scene_view import POSES, WORLD

ROBOT, SCENE = "robot", "scene"
_PARTS = (f"/{WORLD}/{ROBOT}/", f"/{WORLD}/{SCENE}/")
_KINDS = ("Ellipsoids3D", "Capsules3D", "Cylinders3D", "Boxes3D", "Mesh3D")
_SOLID = 3  # as rerun counts kinds of filling; other ones can be seen through
_SEEN_THROUGH = 0.3  # opacity of what perception cannot see
_WHITE = 0xFFFFFFFF
_UNFIT = (KeyError, TypeError, ValueError, IndexError)  # what a damaged or an older recording may lack


@dataclass(frozen=True)
class Shape:
    """A shape that hangs on a body.

    Attributes:
        part: robot or scene.
        body: name of the body or of the thing.
        frame: it is fixed to: the body's, or the world's.
        kind: rerun's name of it, one of Ellipsoids3D, Capsules3D, Cylinders3D, Boxes3D, Mesh3D.
        position: in the frame, shape (3,) [m].
        quaternion: in the frame, xyzw, shape (4,).
        values: what rerun knows of it by name, such as half_sizes, radii, lengths, vertex_positions [m].
        color: red, green, blue and opacity, shape (4,), in [0, 1].
    """

    part: str
    body: str
    frame: str
    kind: str
    position: Array
    quaternion: Array
    values: dict[str, Array]
    color: Array


@dataclass
class Drawing:
    """What the 3D view shows.

    Attributes:
        shapes: by the path of their entity.
        looks: engine time [s], path of a shape, the colour that it has from then on; in the order of time.
        poses: batches of engine times [s], shape (n,), names of frames, positions [m], shape (n, 3), and quaternions
            xyzw, shape (n, 4), all in the world; in the order of time.
    """

    shapes: dict[str, Shape] = field(default_factory=dict)
    looks: list[tuple[float, str, Array]] = field(default_factory=list)
    poses: list[tuple[Array, list[str], Array, Array]] = field(default_factory=list)

    def parts(self) -> Iterator[tuple[float, str, list[Shape]]]:
        """Yield engine time [s], robot or scene, and all its shapes; again whenever a colour changes."""
        begin = float(self.poses[0][0][0]) if self.poses else 0.0
        shapes = dict(self.shapes)
        for _, path, color in [look for look in self.looks if look[0] <= begin]:
            shapes[path] = replace(shapes[path], color=color)
        for part in (ROBOT, SCENE):
            if some := [shape for shape in shapes.values() if shape.part == part]:
                yield begin, part, some
        for time, path, color in [look for look in self.looks if look[0] > begin]:
            shapes[path] = replace(shapes[path], color=color)
            part = shapes[path].part
            yield time, part, [shape for shape in shapes.values() if shape.part == part]


def read_drawing(path: Path) -> Drawing:
    """Return what the 3D view of a recording shows; what cannot be read of it is left out."""
    drawing = Drawing()
    for file in files_of(path):
        for entity, batch in RrdFile(file).batches_of(lambda name: name == f"/{POSES}" or name.startswith(_PARTS)):
            try:
                if entity == f"/{POSES}":
                    drawing.poses.append(_poses(batch))
                elif "sim_time" in batch.schema.names:
                    drawing.looks += [look for look in _looks(entity, batch) if entity in drawing.shapes]
                elif shape := _shape(entity, batch.to_pylist()[0]):
                    drawing.shapes.setdefault(entity, shape)
            except _UNFIT:
                continue
    drawing.looks.sort(key=lambda look: look[0])
    return drawing


def _poses(batch: Any) -> tuple[Array, list[str], Array, Array]:
    numbers = {
        name: np.array(batch.column(f"Transform3D:{name}").to_pylist(), dtype=float)[:, 0]
        for name in ("translation", "quaternion")
    }
    frames = [frame[0] for frame in batch.column("Transform3D:child_frame").to_pylist()]
    return _times(batch), frames, numbers["translation"], numbers["quaternion"]


def _times(batch: Any) -> Array:
    return np.asarray(batch.column("sim_time").cast("int64"), dtype=float) * 1e-9


def _looks(entity: str, batch: Any) -> Iterator[tuple[float, str, Array]]:
    for time, row in zip(_times(batch), batch.to_pylist(), strict=True):
        if kind := _kind(row):
            yield float(time), entity, _color(kind, row)


def _shape(entity: str, row: dict[str, Any]) -> Shape | None:
    """Return a shape; None if it is none, or the floor, which is patterned and for which viewers have their grid."""
    kind = _kind(row)
    if kind is None or "Mesh3D:vertex_colors" in row:
        return None
    _, _, part, body, *_ = entity.replace("\\", "").split("/")
    values = {name.partition(":")[2]: np.array(value) for name, value in row.items() if name.startswith(f"{kind}:")}
    position, quaternion = (np.array(row[f"InstancePoses3D:{n}"][0]) for n in ("translations", "quaternions"))
    frame = row["CoordinateFrame:frame"][0]
    return Shape(part, body, frame, kind, position, quaternion, values, _color(kind, row))


def _kind(row: dict[str, Any]) -> str | None:
    return next((kind for kind in _KINDS if any(name.startswith(f"{kind}:") for name in row)), None)


def _color(kind: str, row: dict[str, Any]) -> Array:
    color = (row.get(f"{kind}:colors") or row.get(f"{kind}:albedo_factor") or [_WHITE])[0]
    rgba = np.array([color >> shift & 255 for shift in (24, 16, 8, 0)]) / 255
    filling = row.get(f"{kind}:fill_mode") or [_SOLID]
    rgba[3] = min(rgba[3], 1.0 if filling[0] == _SOLID else _SEEN_THROUGH)
    return rgba
