"""What a recording holds as messages of topics, for Foxglove and PlotJuggler."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import Any, NamedTuple

from humanoid_bt.record.reading import AT
from humanoid_bt.review.drawing import Drawing, read_drawing
from humanoid_bt.review.export import Wanted
from humanoid_bt.review.happened import Row
from humanoid_bt.review.mcap_scene import scene_update
from humanoid_bt.review.mcap_schemas import FRAMES, JOINTS, LOG, POSE, SCENE, SERVO, own_schema
from humanoid_bt.review.recording import Recording

WORLD, BASE = "world", "base"
_LEVELS = {"debug": 1, "info": 2, "warning": 3, "error": 4}
_STATUS_LEVELS = {"FAILURE": 3}
_STATE = {"position": "position", "velocity": "velocity", "effort": "torque"}


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
    own = (_own(recording, wanted, name, topic) for name, topic in TOPICS.items())
    drawing = read_drawing(recording.path)
    parts = [_scene(drawing, wanted), _bodies(drawing, wanted), _base(recording, wanted)]
    parts += [_joints(recording, wanted), _percepts(recording, wanted)]
    parts += [_logs(recording, wanted, "events"), _logs(recording, wanted, "nodes"), *own]
    return heapq.merge(*parts, key=lambda message: message.time)


TOPICS = {
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


def _scene(drawing: Drawing, wanted: Wanted) -> Iterator[Message]:
    """Yield robot and scene, with bodies fixed to their frames."""
    begin, end = wanted.between or (-math.inf, math.inf)
    latest = {part: shapes for time, part, shapes in drawing.parts() if time <= begin + AT}
    for part, shapes in latest.items():
        yield Message(begin, f"/{part}", SCENE, scene_update(shapes, _stamp(begin)))
    for time, part, shapes in drawing.parts():
        if begin + AT < time <= end + AT:
            yield Message(time, f"/{part}", SCENE, scene_update(shapes, _stamp(time)))


def _bodies(drawing: Drawing, wanted: Wanted) -> Iterator[Message]:
    """Yield where the bodies are, as often as the 3D view was drawn."""
    begin, end = wanted.between or (-math.inf, math.inf)
    for times, frames, positions, quaternions in drawing.poses:
        rows = zip(times.tolist(), frames, positions.tolist(), quaternions.tolist(), strict=True)
        for time, some in groupby(rows, key=lambda row: row[0]):
            if begin - AT <= time <= end + AT:
                stamp = _stamp(time)
                moved = [_transform(stamp, frame, position, turn) for _, frame, position, turn in some]
                yield Message(time, "/tf", FRAMES, {"transforms": moved})


def _transform(stamp: dict[str, int], frame: str, position: Iterable[float], turn: Iterable[float]) -> dict[str, Any]:
    return {
        "timestamp": stamp,
        "parent_frame_id": WORLD,
        "child_frame_id": frame,
        "translation": dict(zip("xyz", position, strict=True)),
        "rotation": dict(zip("xyzw", turn, strict=True)),
    }


def _joints(recording: Recording, wanted: Wanted) -> Iterator[Message]:
    for time, rows in groupby(_rows(recording, wanted, "joints"), key=lambda row: row["time"]):
        known = {row["joint"]: _without_gaps(row) for row in rows}
        states = [
            {"name": name, **{told: row[own] for told, own in _STATE.items() if own in row}}
            for name, row in known.items()
        ]
        yield Message(time, "/joints", JOINTS, {"timestamp": _stamp(time), "joints": states})
        servo = {name: {key: row[key] for key in row if key not in ("time", "joint")} for name, row in known.items()}
        yield Message(time, "/servo", SERVO, {"timestamp": _stamp(time), **servo})


def _base(recording: Recording, wanted: Wanted) -> Iterator[Message]:
    for row in _rows(recording, wanted, "body"):
        numbers = _without_gaps(row)
        if all(name in numbers for name in ("x", "y", "z", "qx", "qy", "qz", "qw")):
            place, turn = [row[axis] for axis in "xyz"], [row[f"q{axis}"] for axis in "xyzw"]
            base = _transform(_stamp(row["time"]), BASE, place, turn)
            yield Message(row["time"], "/tf", FRAMES, {"transforms": [base]})


def _percepts(recording: Recording, wanted: Wanted) -> Iterator[Message]:
    for row in _rows(recording, wanted, "percepts"):
        turned = row["qw"] is not None
        turn = {axis: row[f"q{axis}"] for axis in "xyzw"} if turned else _upright(row["heading"] or 0.0)
        pose = {"position": {axis: row[axis] for axis in "xyz"}, "orientation": turn}
        value = {"timestamp": _stamp(row["stamp"]), "frame_id": BASE, "pose": pose}
        yield Message(row["time"], f"/percepts/{row['name']}", POSE, value)


def _upright(heading: float) -> dict[str, float]:
    return {"x": 0.0, "y": 0.0, "z": math.sin(heading / 2), "w": math.cos(heading / 2)}


def _logs(recording: Recording, wanted: Wanted, name: str) -> Iterator[Message]:
    for row in _rows(recording, wanted, name):
        node = row.get("node", "")
        level = _LEVELS.get(row["level"], 0) if name == "events" else _STATUS_LEVELS.get(row["status"], 2)
        text = row["text"] if name == "events" else f"{row['status']} {row['text']}".strip()
        file, line = _file_and_line(recording.happened.known(node, row["time"]).place)
        value = {"timestamp": _stamp(row["time"]), "level": level, "message": text, "name": node}
        yield Message(row["time"], f"/{name}", LOG, {**value, "file": file, "line": line})


def _own(recording: Recording, wanted: Wanted, name: str, topic: str) -> Iterator[Message]:
    for row in _rows(recording, wanted, name):
        value = {"timestamp": _stamp(row["time"]), **_without_gaps(row)}
        yield Message(row["time"], topic.format(**row), own_schema(name), value)


def _rows(recording: Recording, wanted: Wanted, name: str) -> Iterator[Row]:
    for batch in recording.batches(name, between=wanted.between, rate=wanted.rate):
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
