"""The tables that a recording gives: their columns, with units and meanings, declared once for code, docs and files."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import pyarrow as pa

_NAME = pa.dictionary(pa.int16(), pa.string())  # a name that comes again and again
_TYPES: dict[str, Any] = {
    "number": pa.float64(),
    "sample": pa.float32(),  # of a joint; finer than it is recorded
    "count": pa.int64(),
    "boolean": pa.bool_(),
    "text": pa.string(),
    "name": _NAME,
}


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        name: it.
        type: number, sample, count, boolean, text or name.
        meaning: in a few words.
        unit: of a number, "" for none.
    """

    name: str
    type: str
    meaning: str
    unit: str = ""


@dataclass(frozen=True)
class TableSpec:
    """A table.

    Attributes:
        meaning: what a row is.
        columns: in their order; the first is the time by which rows are chosen, if there is one.
        sampled: whether it can be had at several rates.
    """

    meaning: str
    columns: tuple[Column, ...]
    sampled: bool = False

    @cached_property
    def schema(self) -> Any:
        """The table's ``pyarrow.Schema``, with unit and meaning of each column in its metadata."""
        return pa.schema(
            [
                pa.field(c.name, _TYPES[c.type], metadata={"unit": c.unit, "description": c.meaning})
                for c in self.columns
            ],
            metadata={"description": self.meaning},
        )


def _xyz(prefix: str, unit: str, meaning: str, names: str = "xyz") -> tuple[Column, ...]:
    return tuple(Column(f"{prefix}{name}", "number", f"{meaning}, {name}", unit) for name in names)


_TIME = Column("time", "number", "engine time", "s")
_MODE = Column("mode", "name", "what the supervisor allows")
_GAIT = Column("gait", "name", "what the legs do")
_NODE = Column("node", "text", "path of the node")
_KIND = (
    Column("name", "text", "the node's own name"),
    Column("type", "text", "its type, as trees name it"),
    Column("kind", "text", "skill, action, condition, composite or decorator"),
)
_JSON = "as JSON"

TABLES: dict[str, TableSpec] = {
    "joints": TableSpec(
        "A joint at a moment, measured and as it was told.",
        (
            _TIME,
            Column("joint", "name", "the joint"),
            Column("position", "sample", "measured", "rad"),
            Column("velocity", "sample", "measured", "rad/s"),
            Column("torque", "sample", "applied by the drive", "Nm"),
            Column("setpoint", "sample", "position that the servo was told", "rad"),
            Column("setpoint_velocity", "sample", "velocity that the servo was told", "rad/s"),
            Column("feedforward", "sample", "torque that the servo was told", "Nm"),
            Column("limited", "boolean", "at a soft, rate or torque limit"),
        ),
        sampled=True,
    ),
    "body": TableSpec(
        "The body as a whole at a moment.",
        (
            _TIME,
            _MODE,
            _GAIT,
            Column("command", "count", "sequence of the command in force, null for none"),
            *_xyz("", "m", "base in the world"),
            *_xyz("q", "", "base quaternion in the world", "wxyz"),
            *_xyz("v", "m/s", "base velocity in the world"),
            *_xyz("w", "rad/s", "base turn rate in the base frame"),
            Column("foot_force_left", "number", "normal force on the left foot", "N"),
            Column("foot_force_right", "number", "normal force on the right foot", "N"),
            Column(
                "hand_error_left",
                "number",
                "left palm of the plan to its goal in this step, null for none",
                "m",
            ),
            Column(
                "hand_error_right",
                "number",
                "right palm of the plan to its goal in this step, null for none",
                "m",
            ),
            *_xyz("com_error_", "m", "centre of mass to where it should be"),
            Column("solved", "boolean", "inverse kinematics found a solution"),
        ),
        sampled=True,
    ),
    "ticks": TableSpec(
        "A tick of the tree.",
        (
            _TIME,
            Column("took", "number", "how long it took, on the wall clock; null in a pause and after the tree", "s"),
            Column("running", "text", "paths of the deepest running nodes after it, with ' | ' between several"),
            _MODE,
            _GAIT,
            Column("settled", "boolean", "standing, at rest, no step pending"),
            Column("command", "count", "sequence of what it commanded, null after an exception"),
            Column("stance_x", "number", "middle between the feet, x", "m"),
            Column("stance_y", "number", "middle between the feet, y", "m"),
            Column("stance_heading", "number", "heading of the stance", "rad"),
            *_xyz("com_", "m", "centre of mass in the world"),
            *_xyz("hand_left_", "m", "left palm in the world"),
            *_xyz("hand_right_", "m", "right palm in the world"),
            Column("limited", "text", "joints at a limit, with ' | ' between several"),
            Column("stop_reason", "text", "why the mode is not run"),
        ),
    ),
    "nodes": TableSpec(
        "A node's status changed.",
        (
            _TIME,
            _NODE,
            *_KIND,
            Column("status", "text", "RUNNING, SUCCESS, FAILURE, or INVALID when halted"),
            Column("text", "text", "what it said"),
        ),
    ),
    "spans": TableSpec(
        "A node ran, from its first tick to its end; of nodes that ended in their first tick, only skills.",
        (
            _TIME,
            Column("ended", "number", "engine time of its end, or of the tree's", "s"),
            Column("duration", "number", "how long it ran", "s"),
            _NODE,
            *_KIND,
            Column("status", "text", "how it ended: SUCCESS, FAILURE, INVALID when halted; RUNNING if it did not"),
            Column("text", "text", "what it said then"),
        ),
    ),
    "percepts": TableSpec(
        "A percept reached the tree.",
        (
            _TIME,
            Column("name", "text", "the percept's name"),
            Column("stamp", "number", "engine time at which it was seen", "s"),
            Column("age", "number", "how old it was when it came", "s"),
            *_xyz("", "m", "in the base frame at the stamp"),
            Column("distance", "number", "from the base, in the horizontal plane", "m"),
            Column("confidence", "number", "in [0, 1]"),
            Column(
                "length", "number", "of the upright box around a solid thing, an obstacle; null of anything else", "m"
            ),
            Column("width", "number", "of that box", "m"),
            Column("height", "number", "of that box", "m"),
            Column("heading", "number", "of the box's length, in the base frame", "rad"),
            *(Column(f"q{axis}", "number", "of its own frame in the base frame, if it is told") for axis in "wxyz"),
            Column("class", "text", "what kind of thing it is, if it is told"),
            *(
                Column(f"deviation_{axis}", "number", "standard deviation of its position, if it is told", "m")
                for axis in "xyz"
            ),
        ),
    ),
    "contacts": TableSpec(
        "A tick felt that something touches arms or torso.",
        (
            _TIME,
            Column("group", "name", "which links: left_arm, right_arm or torso"),
            Column("force", "number", "with which it pushes the robot", "N"),
            *_xyz("", "N", "that force in the world"),
            Column("largest", "number", "the largest since the touch began", "N"),
            Column("yields", "boolean", "whether the arm yields to it"),
        ),
    ),
    "commands": TableSpec(
        "A tick commanded a resource.",
        (
            _TIME,
            Column("sequence", "count", "of the command"),
            Column("resource", "text", "base, left_hand, right_hand, gaze or posture"),
            _NODE,
            *_xyz("", "m", "target in the world, or as seen from the other palm"),
            Column("relative", "boolean", "whether a hand's target is as seen from the other palm"),
            *(Column(f"q{part}", "number", "orientation of a palm's frame") for part in "wxyz"),
            Column("axis", "text", "axis of a palm that is to point along a direction: fingers or facing"),
            *(Column(f"d{axis}", "number", "that direction, a unit vector") for axis in "xyz"),
            Column("joints", "text", "angles of an arm's joints [rad], as JSON"),
            Column("speed", "number", "at most this fast: a hand [m/s], the joints of an arm [rad/s]"),
            Column("press", "number", "force with which a palm is to press; 0 where it is to touch nothing", "N"),
            Column("heading", "number", "target of the base", "rad"),
            Column("height", "number", "target of the posture: offset of the centre of mass", "m"),
        ),
    ),
    "results": TableSpec(
        "A skill reported a result: in every tick in which it ran, and when it ended.",
        (
            _TIME,
            _NODE,
            Column("result", "text", "its name"),
            Column("value", "number", "its value in its unit, null if it is no number"),
            Column("text", "text", "its value if it is no number"),
            Column("unit", "text", "SI unit of the value"),
        ),
    ),
    "events": TableSpec(
        "Something else happened: scene events, stops, refused commands, what nodes tell.",
        (_TIME, Column("level", "text", "info, warning or error"), Column("text", "text", "what happened")),
    ),
    "blackboard": TableSpec(
        "A key of the blackboard changed.",
        (
            _TIME,
            Column("key", "text", "its name, below the path of its sub-tree's node"),
            Column("value", "text", f"its value {_JSON}, null if it has none any more"),
        ),
    ),
    "stops": TableSpec(
        "The supervisor ordered a stop.",
        (
            _TIME,
            Column("mode", "text", "what it allows from then on"),
            Column("reason", "text", "why"),
            Column("source", "text", "who asked or what caused it"),
        ),
    ),
    "inputs": TableSpec(
        "Something came from outside that is not sensed: a push, a reset, what was set or forced, an answer to a call.",
        (
            _TIME,
            Column("kind", "text", "push, reset, reset_after_tick, key, set, force or answer"),
            Column("value", "text", _JSON),
        ),
    ),
    "limits": TableSpec(
        "A joint's limits; null where it has none.",
        (
            Column("joint", "text", "the joint"),
            Column("torque", "number", "largest torque of the drive", "Nm"),
            Column("speed", "number", "largest speed", "rad/s"),
            Column("lower", "number", "lower soft limit", "rad"),
            Column("upper", "number", "upper soft limit", "rad"),
        ),
    ),
    "parameters": TableSpec(
        "A parameter of the tree.",
        (
            Column("name", "text", "its name"),
            Column("value", "text", f"its value in SI units, {_JSON}"),
            Column("written", "text", "as it was written, with its unit"),
            Column("origin", "text", "file:line:column, or given from outside"),
        ),
    ),
}
"""Name of a table -> what is in it."""
