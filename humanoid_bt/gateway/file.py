"""Gateway files: which topics of ROS 2 a run listens to, and which it publishes."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from humanoid_bt.core.errors import Problem
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import param
from humanoid_bt.core.reading import read
from humanoid_bt.files import document
from humanoid_bt.gateway.percepts import READERS

FOLDER = "gateways"
"""Folder of a workspace in which gateway files are."""

_NAME = re.compile(r"(~/|/)?[A-Za-z_][\w/]*")  # https://design.ros2.org/articles/topic_and_service_names.html
_TYPE = re.compile(r"[a-z]\w*/(msg|srv|action)/[A-Z]\w*|[a-z]\w*/[A-Z]\w*")
_FRAME = re.compile(r"[A-Za-z_][\w/.-]*")
_UNIT_LENGTH = 0.01  # how far the length of a written quaternion may be from 1


@dataclass(frozen=True, kw_only=True)
class Qos:
    """Quality of service of a topic: what is not given is as the topic's row in docs/ros.md says."""

    reliability: Literal["reliable", "best_effort"] | None = param(None, doc="Whether lost messages are sent again.")
    durability: Literal["volatile", "transient_local"] | None = param(
        None, doc="Whether who comes later still gets the last messages."
    )
    depth: int | None = param(None, minimum=1, maximum=1000, doc="How many messages wait.")

    def over(self, default: Qos) -> Qos:
        """Return this one, with what it leaves open from another."""
        given = {part.name: getattr(self, part.name) for part in dataclasses.fields(self)}
        return Qos(**{name: getattr(default, name) if value is None else value for name, value in given.items()})


@dataclass(frozen=True, kw_only=True)
class PerceptTopic:
    """A topic that a percept comes from."""

    topic: str = param(doc="Its name.")
    type: str = param("geometry_msgs/PoseStamped", doc="Its type, such as geometry_msgs/PoseStamped.")
    confidence: float = param(1.0, minimum=0, maximum=1, doc="Of messages that say nothing about it.")
    class_: str = param("", doc="Of several detections, only those of this class; the surest of them counts.")
    fields: dict[str, str] = param(
        {}, doc="Of any other type: where x, y, z and perhaps confidence are, as in {x: point.x, confidence: data.3}."
    )
    solid: bool = param(False, doc="Whether the box of a detection is an obstacle.")
    frame: str = param("", doc="Frame of messages that name none; the robot's base if not given.")
    stamp: Literal["message", "arrival"] = param(
        "message", doc="When it was seen: as the message's header says, or when it arrives, for types without header."
    )
    qos: Qos = param(Qos(), doc="Quality of service.")

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what is wrong with names and fields."""
        yield from name_mistakes(item, values)
        kind, given = values.get("type", "geometry_msgs/PoseStamped"), values.get("fields", {})
        if not _TYPE.fullmatch(kind):
            hint = "PACKAGE/TYPE, as ros2 topic info prints it"
            yield Problem(f"{kind!r} is no type of messages", item.place_of("type"), hint, "bad-name")
        elif plain_type(kind) not in READERS and not {"x", "y", "z"} <= set(given):
            hint = f"fields: {{x: ..., y: ..., z: ...}}, or one of {', '.join(READERS)}"
            yield Problem(
                f"where a {kind!r} has its x, y and z is not said", item.place_of("type"), hint, "missing-key"
            )
        for name in given:
            if name not in (known := ("x", "y", "z", "confidence")):
                place = item.value["fields"].key_places.get(name, item.place)
                yield Problem(f"a percept has no field {name!r}", place, f"valid: {', '.join(known)}", "unknown-key")


@dataclass(frozen=True, kw_only=True)
class EStopTopic:
    """A topic that stops the robot."""

    topic: str = param("/estop", doc="Its name; of type std_msgs/Bool, true stops the robot, false does nothing.")
    timeout: float | None = param(
        None, unit="s", above=0, doc="Silence that stops the robot too; none does if not given."
    )
    reset: str = param("", doc="Service, of type std_srvs/Trigger, that asks for a reset; none if not given.")
    qos: Qos = param(Qos(), doc="Quality of service.")

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what is wrong with names."""
        yield from name_mistakes(item, values, ("topic", "reset"))


@dataclass(frozen=True, kw_only=True)
class TreeAction:
    """The tree as an action: it runs once for every goal."""

    name: str = param(doc="Its name.")
    type: str = param(doc="Its type, such as my_interfaces/action/Fetch.")
    parameters: dict[str, str] = param({}, doc="Parameters of the tree, each with where in the goal its value is.")
    feedback: dict[str, Literal["node", "feedback", "time"]] = param({}, doc="Fields of the feedback: what they hold.")
    result: dict[str, Literal["outcome", "reason", "success"]] = param({}, doc="Fields of the result: what they hold.")

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what is wrong with names."""
        yield from name_mistakes(item, values, ("name",))


@dataclass(frozen=True, kw_only=True)
class Output:
    """A topic that is published; what is not given is as its row in docs/ros.md says."""

    topic: str = param("", doc="Its name.")
    rate: float | None = param(None, unit="Hz", above=0, maximum=50, doc="How often.")
    qos: Qos = param(Qos(), doc="Quality of service.")

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what is wrong with names."""
        yield from name_mistakes(item, values)


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """What is published: {} for a topic with its usual name, rate and quality of service."""

    joint_states: Output | None = param(None, doc="sensor_msgs/JointState: positions, velocities, torques.")
    odometry: Output | None = param(None, doc="nav_msgs/Odometry: where control believes the base to be.")
    tf: Output | None = param(None, doc="tf2_msgs/TFMessage: the base in the odometry's frame.")
    diagnostics: Output | None = param(None, doc="diagnostic_msgs/DiagnosticArray: mode, stop, tree, percepts, timing.")
    status: Output | None = param(None, doc="std_msgs/String: what the tree does, as JSON.")
    nodes: Output | None = param(None, doc="std_msgs/String: every node whose status changed, as JSON.")
    events: Output | None = param(None, doc="std_msgs/String: what happens, as JSON.")
    command: Output | None = param(None, doc="std_msgs/String: the command in force, as JSON.")
    image: Output | None = param(None, doc="sensor_msgs/Image: what the head camera sees, rgb8.")
    depth: Output | None = param(None, doc="sensor_msgs/Image: how far away that is, 32FC1.")
    camera_info: Output | None = param(None, doc="sensor_msgs/CameraInfo: of both.")
    robot_description: Output | None = param(None, doc="std_msgs/String: the robot's model, once, latched.")


@dataclass(frozen=True, kw_only=True)
class FixedFrame:
    """A frame that does not move in another one, where nobody says so on /tf_static."""

    parent: str = param(doc="The other one.")
    position: tuple[float, float, float] = param((0.0, 0.0, 0.0), unit="m", doc="Of its origin there.")
    orientation: tuple[float, float, float, float] = param((1.0, 0.0, 0.0, 0.0), doc="Of its axes there, wxyz.")

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what is wrong with the quaternion."""
        length = math.hypot(*values.get("orientation", (1.0,)))
        if abs(length - 1) > _UNIT_LENGTH:
            message = f"an orientation is a unit quaternion wxyz, and this has the length {length:g}"
            yield Problem(message, item.place_of("orientation"), "none: [1, 0, 0, 0]", "out-of-range")


@dataclass(frozen=True, kw_only=True)
class Frames:
    """What the frames of the engine are called in ROS 2, and what others are in them."""

    base: str = param("base_link", doc="The robot's base frame.")
    odom: str = param("odom", doc="The world of the engine: odometry, which drifts.")
    camera: str = param("head_camera_optical_frame", doc="The head camera's optical frame: z ahead, y down.")
    tf: bool = param(False, doc="Listen to /tf and /tf_static, of type tf2_msgs/TFMessage, for all other frames.")
    fixed: dict[str, FixedFrame] = param({}, doc="Frames that do not move in another one.")

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what is wrong with names, and frames that hang on nothing."""
        base, odom = values.get("base", "base_link"), values.get("odom", "odom")
        for key in ("base", "odom", "camera"):
            if not _FRAME.fullmatch(values.get(key, "x")):
                yield Problem(f"{values[key]!r} cannot be a frame", item.place_of(key), "a name without /", "bad-name")
        if base == odom:
            yield Problem(f"base and odom are both {base!r}", item.place_of("odom"), "they move apart", "bad-name")
        fixed = values.get("fixed", {})
        for name in fixed:
            place, way = item.value["fixed"].key_places.get(name, item.place), [name]
            while (parent := fixed[way[-1]].parent) in fixed and parent not in way:
                way.append(parent)
            if parent in way:
                yield Problem(f"the frame {name!r} hangs on itself: {' in '.join(way)}", place, "", "bad-name")
            elif parent not in (base, odom) and not values.get("tf", False):
                hint = f"a parent is {base}, {odom} or another fixed frame; or tf: true"
                yield Problem(f"nobody knows where the frame {parent!r} is", place, hint, "unknown-key")


@dataclass(frozen=True, kw_only=True)
class GatewayFile:
    """Which topics of ROS 2 a run listens to, and which it publishes."""

    format: int = param(doc="Version of this file's form: 1.", minimum=1, maximum=1)
    description: str = param("", doc="One line for people.")
    node: str = param("humanoid_bt", doc="Name of the node.")
    network: Literal["loopback", "ros"] = param(
        "loopback", doc="Who is found: only nodes on this machine, or what the variables of ROS 2 say."
    )
    frames: Frames = param(Frames(), doc="Names of frames.")
    percepts: dict[str, PerceptTopic] = param({}, doc="The percepts that come from topics.")
    estop: EStopTopic | None = param(None, doc="What stops the robot.")
    parameters: Literal["none", "read", "set"] = param(
        "none", doc="Whether the node shows the tree's parameters, and whether others may set them while it runs."
    )
    action: TreeAction | None = param(None, doc="The tree as an action; without it the tree starts with the run.")
    publish: Outputs = param(Outputs(), doc="What is published.")
    path: Path = field(default=Path())

    @staticmethod
    def mistakes(item: Item, values: Mapping[str, Any]) -> Iterator[Problem]:
        """Return what is wrong with the node's name."""
        if not re.fullmatch(r"[A-Za-z_]\w*", values.get("node", "x")):
            yield Problem(
                f"{values['node']!r} cannot be a node", item.place_of("node"), "letters, digits, _", "bad-name"
            )


def load_gateway(path: Path) -> GatewayFile:
    """Read a gateway file.

    Raises:
        UserError: with every problem found, each with its place.
    """
    found: GatewayFile = read(GatewayFile, document.load(path), "the gateway")
    return dataclasses.replace(found, path=path)


def name_mistakes(item: Item, values: Mapping[str, Any], keys: tuple[str, ...] = ("topic",)) -> Iterator[Problem]:
    """Yield the names of topics and services that ROS 2 would refuse."""
    for key in keys:
        if values.get(key) and (not _NAME.fullmatch(values[key]) or "//" in values[key] or values[key].endswith("/")):
            hint = "letters, digits, _ and /, as in /camera/ball"
            yield Problem(f"{values[key]!r} cannot be a {key}", item.place_of(key), hint, "bad-name")


def plain_type(name: str) -> str:
    """Return the type of a message as PACKAGE/TYPE, however it is written."""
    return name.replace("/msg/", "/")
