"""Messages of what a run says of itself, made without ROS 2."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.messages import BaseTarget, Mode
from humanoid_bt.gateway import outputs
from humanoid_bt.gateway.file import Frames
from humanoid_bt.gateway.snapshot import Snapshot
from tests.tree.helpers import make_state


class Message:
    """A message that has every field."""

    def __init__(self, **values: Any) -> None:
        vars(self).update(values)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        vars(self)[name] = found = Message()
        return found


def types(_name: str) -> type[Message]:
    return Message


@pytest.fixture
def now() -> Snapshot:
    quarter = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])  # it faces along the world's y
    state = dataclasses.replace(
        make_state(4.0),
        base_position=np.array([1.0, 2.0, 0.8]),
        base_quaternion=quarter,
        base_linear_velocity=np.array([0.0, 0.5, 0.0]),
        base_angular_velocity=np.array([0.0, 0.0, 0.1]),
        base_covariance=np.diag(np.arange(1.0, 10.0)),
    )
    return Snapshot(state, 1000.25, ["hip", "knee"], Frames(base="pelvis"), None, {"node": "a/b"}, {"late_p99": 12.0})


def test_stamps_are_ros_time(now: Snapshot) -> None:
    stamp = outputs.joint_states(types, now).header.stamp
    assert (stamp.sec, stamp.nanosec) == (1000, 250_000_000)


def test_odometry_has_its_velocity_in_the_base_frame(now: Snapshot) -> None:
    message = outputs.odometry(types, now)
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "pelvis")
    linear = message.twist.twist.linear
    assert [linear.x, linear.y, linear.z] == pytest.approx([0.5, 0, 0])
    assert message.twist.twist.angular.z == pytest.approx(0.1)
    assert message.pose.pose.orientation.z == pytest.approx(np.sqrt(0.5))


def test_covariances_are_of_position_before_turn(now: Snapshot) -> None:
    message = outputs.odometry(types, now)
    assert message.pose.covariance.reshape(6, 6).diagonal().tolist() == [7, 8, 9, 1, 2, 3]
    assert message.twist.covariance.reshape(6, 6).diagonal() == pytest.approx([5, 4, 6, 0, 0, 0])


def test_tf_is_the_base_in_the_frame_of_odometry(now: Snapshot) -> None:
    (transform,) = outputs.tf(types, now).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", "pelvis")
    moved = transform.transform.translation
    assert [moved.x, moved.y, moved.z] == [1, 2, 0.8]


def test_diagnostics_of_a_stop_are_an_error(now: Snapshot) -> None:
    assert outputs.diagnostics(types, now).status[0].level == b"\x00"
    stopped = dataclasses.replace(now.state, mode=Mode.EMERGENCY_STOP, stop_reason="it was raised", stop_source="me")
    status = outputs.diagnostics(types, dataclasses.replace(now, state=stopped)).status[0]
    assert (status.level, status.message) == (b"\x02", "emergency stop: it was raised (me)")


def test_the_command_in_force_names_who_gave_it(now: Snapshot) -> None:
    targets = {"base": BaseTarget(np.array([1.0, 2.0]), 0.5)}
    state = dataclasses.replace(now.state, targets=targets, command_sources={"base": "tree/approach"})
    message = outputs.command(types, dataclasses.replace(now, state=state))
    said = json.loads(message.data)
    assert said["sources"] == {"base": "tree/approach"}
    assert said["targets"]["base"]["position"] == [1.0, 2.0]
