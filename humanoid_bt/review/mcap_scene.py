"""The robot and the scene of a recording's 3D view, as entities of foxglove.SceneUpdate."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from itertools import groupby
from typing import Any

import numpy as np
import trimesh

from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Array
from humanoid_bt.review.drawing import Shape

_GLB = "model/gltf-binary"
_Z_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], dtype=float)  # to y up, as glTF has it
_ROUGHNESS = 0.8
_FOREVER = {"sec": 0, "nsec": 0}
_UNFIT = (KeyError, TypeError, ValueError, IndexError)  # what a damaged or an older recording may lack
_EMPTY = ("metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")


def scene_update(shapes: Iterable[Shape], stamp: dict[str, int]) -> dict[str, Any]:
    """Return shapes as a message: an entity for each body, which stays until the next message.

    Args:
        shapes: what there is to see.
        stamp: engine time, as messages have it.
    """
    entities = []
    for (frame, body), some in groupby(sorted(shapes, key=_place), _place):
        entity: dict[str, Any] = {
            "timestamp": stamp,
            "frame_id": frame,
            "id": body,
            "lifetime": _FOREVER,
            "frame_locked": True,
            **{kind: [] for kind in _EMPTY},
        }
        for shape in some:
            try:
                drawn = list(_DRAWN[shape.kind](shape))
            except _UNFIT:
                continue
            for kind, primitive in drawn:
                entity[kind].append(primitive)
        entities.append(entity)
    return {"deletions": [], "entities": entities}


def _place(shape: Shape) -> tuple[str, str]:
    return shape.frame, shape.body


def _ellipsoid(shape: Shape) -> Iterable[tuple[str, Any]]:
    yield "spheres", _primitive(shape, 2 * shape.values["half_sizes"][0])


def _box(shape: Shape) -> Iterable[tuple[str, Any]]:
    yield "cubes", _primitive(shape, 2 * shape.values["half_sizes"][0])


def _cylinder(shape: Shape) -> Iterable[tuple[str, Any]]:
    radius, length = shape.values["radii"][0], shape.values["lengths"][0]
    even = {"bottom_scale": 1.0, "top_scale": 1.0}
    yield "cylinders", {**_primitive(shape, [2 * radius, 2 * radius, length]), **even}


def _capsule(shape: Shape) -> Iterable[tuple[str, Any]]:
    yield from _cylinder(shape)
    radius, length = shape.values["radii"][0], shape.values["lengths"][0]
    axis = rotation_matrix(shape.quaternion[[3, 0, 1, 2]])[:, 2]
    for end in (-length / 2, length / 2):
        yield "spheres", {**_primitive(shape, [2 * radius] * 3), "pose": _pose(shape, shape.position + end * axis)}


def _mesh(shape: Shape) -> Iterable[tuple[str, Any]]:
    vertices = shape.values["vertex_positions"]
    triangles = shape.values.get("triangle_indices")
    mesh = trimesh.Trimesh(
        vertices,
        np.arange(len(vertices)).reshape(-1, 3) if triangles is None else triangles,
        vertex_normals=shape.values.get("vertex_normals"),
        process=False,
    )
    mesh.apply_transform(_Z_UP)
    mesh.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(
            baseColorFactor=np.round(shape.color * 255).astype(np.uint8),
            metallicFactor=0.0,
            roughnessFactor=_ROUGHNESS,
            alphaMode="OPAQUE" if shape.color[3] == 1 else "BLEND",
        )
    )
    data = mesh.export(file_type="glb", include_normals="vertex_normals" in shape.values)
    yield (
        "models",
        {
            "pose": _pose(shape, shape.position),
            "scale": _xyz([1.0, 1.0, 1.0]),
            "color": _rgba(shape.color),
            "override_color": False,
            "url": "",
            "media_type": _GLB,
            "data": base64.b64encode(data).decode(),
        },
    )


_DRAWN = {
    "Ellipsoids3D": _ellipsoid,
    "Boxes3D": _box,
    "Cylinders3D": _cylinder,
    "Capsules3D": _capsule,
    "Mesh3D": _mesh,
}


def _primitive(shape: Shape, size: Iterable[float]) -> dict[str, Any]:
    return {"pose": _pose(shape, shape.position), "size": _xyz(size), "color": _rgba(shape.color)}


def _pose(shape: Shape, position: Array) -> dict[str, Any]:
    turn = dict(zip("xyzw", map(float, shape.quaternion), strict=True))
    return {"position": _xyz(position), "orientation": turn}


def _xyz(values: Iterable[float]) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def _rgba(values: Array) -> dict[str, float]:
    return dict(zip("rgba", map(float, values), strict=True))
