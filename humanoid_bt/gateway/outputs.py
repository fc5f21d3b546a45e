"""What a run publishes: each kind of topic, and its messages."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Array, Mode
from humanoid_bt.core.plain import plain
from humanoid_bt.gateway.file import Qos
from humanoid_bt.gateway.frames import optical_in_base
from humanoid_bt.gateway.qos import LATCHED, PICTURE, RELIABLE
from humanoid_bt.gateway.snapshot import Snapshot

Types = Callable[[str], Any]
"""Returns a type of messages by its name."""

_OK, _WARN, _ERROR = b"\x00", b"\x01", b"\x02"  # diagnostic_msgs/DiagnosticStatus
_LEVELS = {Mode.RUN: _OK, Mode.PAUSED: _WARN}


@dataclass(frozen=True)
class Kind:
    """A kind of topic.

    Attributes:
        topic: what it is called where the file does not say.
        type: of its messages.
        rate: how often it is published where the file does not say [Hz]; 0 for whenever there is something new.
        qos: where the file does not say.
        message: makes a message; None for what is told by others, one by one.
    """

    topic: str
    type: str
    rate: float
    qos: Qos = RELIABLE
    message: Callable[[Types, Snapshot], Any] | None = None


def joint_states(types: Types, now: Snapshot) -> Any:
    """Return what the joints do [rad], [rad/s], [Nm]."""
    message = stamped(types("sensor_msgs/JointState")(), now.stamp, "")
    message.name = list(now.joints)
    message.position = now.state.joint_positions.tolist()
    message.velocity = now.state.joint_velocities.tolist()
    message.effort = now.state.joint_torques.tolist()
    return message


def odometry(types: Types, now: Snapshot) -> Any:
    """Return where control believes the base to be, and how fast it moves in its own frame."""
    state, frames = now.state, now.frames
    message = stamped(types("nav_msgs/Odometry")(), now.stamp, frames.odom)
    message.child_frame_id = frames.base
    _set_vector(message.pose.pose.position, state.base_position)
    _set_quaternion(message.pose.pose.orientation, state.base_quaternion)
    turn = rotation_matrix(state.base_quaternion).T
    _set_vector(message.twist.twist.linear, turn @ state.base_linear_velocity)
    _set_vector(message.twist.twist.angular, state.base_angular_velocity)
    order = [6, 7, 8, 0, 1, 2]  # there position and turn, here turn, velocity and position
    message.pose.covariance = state.base_covariance[np.ix_(order, order)].ravel()
    velocity: Array = np.zeros((6, 6))
    velocity[:3, :3] = turn @ state.base_covariance[3:6, 3:6] @ turn.T
    message.twist.covariance = velocity.ravel()
    return message


def tf(types: Types, now: Snapshot) -> Any:
    """Return where the base is in the frame of odometry, and where the head camera was that the last picture shows."""
    transform = stamped(types("geometry_msgs/TransformStamped")(), now.stamp, now.frames.odom)
    transform.child_frame_id = now.frames.base
    _set_vector(transform.transform.translation, now.state.base_position)
    _set_quaternion(transform.transform.rotation, now.state.base_quaternion)
    transforms = [transform]
    if now.picture is not None:
        position, turn = optical_in_base(now.picture)
        camera = stamped(types("geometry_msgs/TransformStamped")(), now.picture_stamp, now.frames.base)
        camera.child_frame_id = now.frames.camera
        _set_vector(camera.transform.translation, position)
        _set_quaternion(camera.transform.rotation, turn)
        transforms.append(camera)
    return types("tf2_msgs/TFMessage")(transforms=transforms)


def diagnostics(types: Types, now: Snapshot) -> Any:
    """Return how the run is: what the supervisor allows, what the tree does, what was seen, how punctual it is."""
    state, told = now.state, now.told
    mode = state.mode.value.replace("_", " ")
    stop = f"{mode}: {state.stop_reason} ({state.stop_source})" if state.stop_reason else mode
    late = now.timing.get("late_p99", 0.0)
    rows = [
        ("supervisor", _LEVELS.get(state.mode, _ERROR), stop, {"mode": state.mode.value, "gait": state.gait.value}),
        ("tree", _OK, told.get("feedback", ""), {"node": told.get("node", ""), "tick rate": told.get("tick_rate", "")}),
        ("percepts", _WARN if told.get("unseen") else _OK, "", {**told.get("percepts", {}), **told.get("unseen", {})}),
        ("control", _OK, f"wake-ups late by {late:.0f} us (p99)", now.timing),
    ]
    message = stamped(types("diagnostic_msgs/DiagnosticArray")(), now.stamp, "")
    message.status = [_status(types, *row) for row in rows]
    return message


def _status(types: Types, name: str, level: bytes, text: str, values: Mapping[str, Any]) -> Any:
    pair = types("diagnostic_msgs/KeyValue")
    status = types("diagnostic_msgs/DiagnosticStatus")()
    status.name, status.hardware_id = f"humanoid_bt: {name}", "humanoid_bt"
    status.level, status.message = level, text
    status.values = [pair(key=str(key), value=str(value)) for key, value in values.items()]
    return status


def status(types: Types, now: Snapshot) -> Any:
    """Return what the tree does, as JSON."""
    tree = now.tree
    nodes = {path: one.name for path, one in tree.statuses.items()} if tree else {}
    said = {key: now.told[key] for key in ("node", "feedback", "tick_rate", "percepts", "unseen") if key in now.told}
    return text(
        types, {"stamp": now.stamp, "time": now.state.time, "mode": now.state.mode.value, **said, "nodes": nodes}
    )


def command(types: Types, now: Snapshot) -> Any:
    """Return the command in force and who gave it, as JSON."""
    state = now.state
    said = {"stamp": now.stamp, "time": state.time, "sequence": state.command_sequence}
    return text(types, {**said, "targets": plain(state.targets), "sources": plain(state.command_sources)})


def text(types: Types, values: Mapping[str, Any]) -> Any:
    """Return data as JSON in a std_msgs/String."""
    return types("std_msgs/String")(data=json.dumps(plain(values)))


KINDS: Mapping[str, Kind] = {
    "joint_states": Kind("joint_states", "sensor_msgs/JointState", 50, message=joint_states),
    "odometry": Kind("odom", "nav_msgs/Odometry", 50, message=odometry),
    "tf": Kind("/tf", "tf2_msgs/TFMessage", 50, message=tf),
    "diagnostics": Kind("/diagnostics", "diagnostic_msgs/DiagnosticArray", 1, message=diagnostics),
    "status": Kind("~/status", "std_msgs/String", 5, message=status),
    "command": Kind("~/command", "std_msgs/String", 10, message=command),
    "nodes": Kind("~/nodes", "std_msgs/String", 0),
    "events": Kind("~/events", "std_msgs/String", 0),
    "image": Kind("camera/image_raw", "sensor_msgs/Image", 0, PICTURE),
    "depth": Kind("camera/depth/image_raw", "sensor_msgs/Image", 0, PICTURE),
    "camera_info": Kind("camera/camera_info", "sensor_msgs/CameraInfo", 0, PICTURE),
    "robot_description": Kind("robot_description", "std_msgs/String", 0, LATCHED),
}
"""What can be published, by its key in the file."""


def stamped(message: Any, stamp: float, frame: str) -> Any:
    """Return a message with a header: ROS time [s] and frame."""
    fraction, seconds = math.modf(stamp)
    message.header.stamp.sec, message.header.stamp.nanosec = int(seconds), int(fraction * 1e9)
    message.header.frame_id = frame
    return message


def _set_vector(message: Any, values: Array) -> None:
    message.x, message.y, message.z = values.tolist()


def _set_quaternion(message: Any, wxyz: Array) -> None:
    message.w, message.x, message.y, message.z = wxyz.tolist()
