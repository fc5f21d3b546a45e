"""JSON schemas of the messages in an MCAP file: those that Foxglove knows, and one for each table of our own."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from humanoid_bt.review.columns import TABLES, TableSpec

JOINTS, FRAMES, POSE = "foxglove.JointStates", "foxglove.FrameTransforms", "foxglove.PoseInFrame"
LOG, SCENE = "foxglove.Log", "foxglove.SceneUpdate"
SERVO = "humanoid_bt.servo"

_NUMBER, _WHOLE, _TEXT = {"type": "number"}, {"type": "integer"}, {"type": "string"}
_YES_OR_NO = {"type": "boolean"}
_TYPES = {"number": _NUMBER, "sample": _NUMBER, "count": _WHOLE, "boolean": _YES_OR_NO}


def own_schema(table: str) -> str:
    """Return the name of the schema of a table's rows."""
    return f"humanoid_bt.{table}"


def schemas(tables: Iterable[str], joints: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return the JSON schema of every kind of message by its name.

    Args:
        tables: those whose rows are messages.
        joints: of the robot.
    """
    row = _of_table(TABLES["joints"], without=("time", "joint"))
    own = {own_schema(name): _of_table(TABLES[name], timestamp=_TIME) for name in tables}
    own[SERVO] = _object(timestamp=_TIME, **dict.fromkeys(joints, row))
    return {name: {"title": name, **schema} for name, schema in {**_known(), **own}.items()}


def _known() -> dict[str, dict[str, Any]]:
    pose = _object(position=_vector("xyz"), orientation=_vector("xyzw"))
    transform = _object(
        timestamp=_TIME,
        parent_frame_id=_TEXT,
        child_frame_id=_TEXT,
        translation=_vector("xyz"),
        rotation=_vector("xyzw"),
    )
    joint = _object(name=_TEXT, position=_NUMBER, velocity=_NUMBER, effort=_NUMBER)
    solid = {"pose": pose, "size": _vector("xyz"), "color": _vector("rgba")}
    model = _object(
        pose=pose,
        scale=_vector("xyz"),
        color=_vector("rgba"),
        override_color=_YES_OR_NO,
        url=_TEXT,
        media_type=_TEXT,
        data={"type": "string", "contentEncoding": "base64"},
    )
    entity = _object(
        timestamp=_TIME,
        frame_id=_TEXT,
        id=_TEXT,
        lifetime={**_TIME, "title": "duration"},
        frame_locked=_YES_OR_NO,
        cubes=_list(_object(**solid)),
        spheres=_list(_object(**solid)),
        cylinders=_list(_object(**solid, bottom_scale=_NUMBER, top_scale=_NUMBER)),
        models=_list(model),
        **dict.fromkeys(("metadata", "arrows", "lines", "triangles", "texts"), _list(_object())),
    )
    deletion = _object(timestamp=_TIME, type=_WHOLE, id=_TEXT)
    return {
        JOINTS: _object(timestamp=_TIME, joints=_list(joint)),
        FRAMES: _object(transforms=_list(transform)),
        POSE: _object(timestamp=_TIME, frame_id=_TEXT, pose=pose),
        LOG: _object(timestamp=_TIME, level=_WHOLE, message=_TEXT, name=_TEXT, file=_TEXT, line=_WHOLE),
        SCENE: _object(deletions=_list(deletion), entities=_list(entity)),
    }


def _of_table(table: TableSpec, without: tuple[str, ...] = (), **more: Any) -> dict[str, Any]:
    described = {
        c.name: {**_TYPES.get(c.type, _TEXT), "description": f"{c.meaning} [{c.unit}]" if c.unit else c.meaning}
        for c in table.columns
        if c.name not in without
    }
    return _object(**more, **described)


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


def _list(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


_TIME = {"title": "time", **_object(sec=_WHOLE, nsec=_WHOLE)}


def _vector(axes: str) -> dict[str, Any]:
    return _object(**dict.fromkeys(axes, _NUMBER))
