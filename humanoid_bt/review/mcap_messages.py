"""What a recording holds as messages of topics, under the schemas that Foxglove and PlotJuggler know."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from itertools import groupby
from typing import Any, NamedTuple

from humanoid_bt.review.columns import TABLES
from humanoid_bt.review.export import Wanted
from humanoid_bt.review.happened import Row
from humanoid_bt.review.recording import Recording

WORLD, BASE = "world", "base"
_LEVELS = {"debug": 1, "info": 2, "warning": 3, "error": 4}
_STATUS_LEVELS = {"FAILURE": 3}


class Message(NamedTuple):
    """A message.

    Attributes:
        time: engine time [s].
        topic: where it goes.
        schema: name of what it is.
        value: as data for JSON.
    """

    time: float
    topic: str
    schema: str
    value: dict[str, Any]


def messages(recording: Recording, wanted: Wanted) -> Iterator[Message]:
    """Yield everything as messages, in the order of time."""
    own = (_own(recording, wanted, name, topic) for name, topic in _TOPICS.items())
    parts = [_joints(recording, wanted), _base(recording, wanted), _percepts(recording, wanted)]
    parts += [_logs(recording, wanted, "events"), _logs(recording, wanted, "nodes"), *own]
    return heapq.merge(*parts, key=lambda message: message.time)


def schemas() -> dict[str, dict[str, Any]]:
    """Return the JSON schema of every kind of message by its name."""
    pose = _object(position=_vector("xyz"), orientation=_vector("xyzw"))
    transform = _object(
        timestamp=_TIME,
        parent_frame_id=_TEXT,
        child_frame_id=_TEXT,
        translation=_vector("xyz"),
        rotation=_vector("xyzw"),
    )
    joint = _object(name=_TEXT, position=_NUMBER, velocity=_NUMBER, effort=_NUMBER)
    known = {
        "foxglove.JointStates": _object(timestamp=_TIME, joints={"type": "array", "items": joint}),
        "foxglove.FrameTransforms": _object(transforms={"type": "array", "items": transform}),
        "foxglove.PoseInFrame": _object(timestamp=_TIME, frame_id=_TEXT, pose=pose),
        "foxglove.Log": _object(timestamp=_TIME, level=_WHOLE, message=_TEXT, name=_TEXT, file=_TEXT, line=_WHOLE),
    }
    own = {_own_schema(name): _of_table(name) for name in _TOPICS}
    return {name: {"title": name, **schema} for name, schema in {**known, **own}.items()}


_TOPICS = {
    "body": "/body",
    "ticks": "/ticks",
    "contacts": "/contacts/{group}",
    "commands": "/commands/{resource}",
    "results": "/results/{node}/{result}",
    "blackboard": "/blackboard",
    "stops": "/stops",
    "inputs": "/inputs",
}
"""Tables whose rows are messages as they are, and their topics."""


def _joints(recording: Recording, wanted: Wanted) -> Iterator[Message]:
    columns = ("time", "joint", "position", "velocity", "torque")
    for time, rows in groupby(_rows(recording, wanted, "joints", columns), key=lambda row: row["time"]):
        states = [_without_gaps({**row, "name": row["joint"], "effort": row["torque"]}) for row in rows]
        kept = [
            {key: state[key] for key in ("name", "position", "velocity", "effort") if key in state} for state in states
        ]
        yield Message(time, "/joints", "foxglove.JointStates", {"timestamp": _stamp(time), "joints": kept})


def _base(recording: Recording, wanted: Wanted) -> Iterator[Message]:
    for row in _rows(recording, wanted, "body"):
        numbers = _without_gaps(row)
        if all(name in numbers for name in ("x", "y", "z", "qx", "qy", "qz", "qw")):
            transform = {
                "timestamp": _stamp(row["time"]),
                "parent_frame_id": WORLD,
                "child_frame_id": BASE,
                "translation": {axis: row[axis] for axis in "xyz"},
                "rotation": {axis: row[f"q{axis}"] for axis in "xyzw"},
            }
            yield Message(row["time"], "/tf", "foxglove.FrameTransforms", {"transforms": [transform]})


def _percepts(recording: Recording, wanted: Wanted) -> Iterator[Message]:
    for row in _rows(recording, wanted, "percepts"):
        turned = row["qw"] is not None
        turn = {axis: row[f"q{axis}"] for axis in "xyzw"} if turned else _upright(row["heading"] or 0.0)
        pose = {"position": {axis: row[axis] for axis in "xyz"}, "orientation": turn}
        value = {"timestamp": _stamp(row["stamp"]), "frame_id": BASE, "pose": pose}
        yield Message(row["time"], f"/percepts/{row['name']}", "foxglove.PoseInFrame", value)


def _upright(heading: float) -> dict[str, float]:
    return {"x": 0.0, "y": 0.0, "z": math.sin(heading / 2), "w": math.cos(heading / 2)}


def _logs(recording: Recording, wanted: Wanted, name: str) -> Iterator[Message]:
    places = {path: node.place for path, node in recording.happened.known.items()}
    for row in _rows(recording, wanted, name):
        node = row.get("node", "")
        level = _LEVELS.get(row["level"], 0) if name == "events" else _STATUS_LEVELS.get(row["status"], 2)
        text = row["text"] if name == "events" else f"{row['status']} {row['text']}".strip()
        file, line = _file_and_line(places.get(node, ""))
        value = {"timestamp": _stamp(row["time"]), "level": level, "message": text, "name": node}
        yield Message(row["time"], f"/{name}", "foxglove.Log", {**value, "file": file, "line": line})


def _own(recording: Recording, wanted: Wanted, name: str, topic: str) -> Iterator[Message]:
    for row in _rows(recording, wanted, name):
        value = {"timestamp": _stamp(row["time"]), **_without_gaps(row)}
        yield Message(row["time"], topic.format(**row), _own_schema(name), value)


def _rows(recording: Recording, wanted: Wanted, name: str, columns: tuple[str, ...] | None = None) -> Iterator[Row]:
    for batch in recording.batches(name, between=wanted.between, rate=wanted.rate, columns=columns):
        yield from batch.to_pylist()


def _without_gaps(row: Row) -> Row:
    """Return what a row has; JSON has no form for what is no number."""
    return {
        name: value
        for name, value in row.items()
        if value is not None and not (isinstance(value, float) and not math.isfinite(value))
    }


def _stamp(time: float) -> dict[str, int]:
    nanoseconds = max(round(time * 1e9), 0)
    return {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}


def _file_and_line(place: str) -> tuple[str, int]:
    """Return the parts of file:line:column."""
    file, line, _ = [*place.rsplit(":", 2), "", ""][:3]
    return file, int(line) if line.isascii() and line.isdigit() else 0


# ---- schemas --------------------------------------------------------------------------------------------------------

_NUMBER, _WHOLE, _TEXT = {"type": "number"}, {"type": "integer"}, {"type": "string"}
_TYPES = {"number": _NUMBER, "sample": _NUMBER, "count": _WHOLE, "boolean": {"type": "boolean"}}


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


_TIME = {"title": "time", **_object(sec=_WHOLE, nsec=_WHOLE)}


def _vector(axes: str) -> dict[str, Any]:
    return _object(**dict.fromkeys(axes, _NUMBER))


def _own_schema(name: str) -> str:
    return f"humanoid_bt.{name}"


def _of_table(name: str) -> dict[str, Any]:
    described = {
        c.name: {**_TYPES.get(c.type, _TEXT), "description": f"{c.meaning} [{c.unit}]" if c.unit else c.meaning}
        for c in TABLES[name].columns
    }
    return _object(timestamp=_TIME, **described)
