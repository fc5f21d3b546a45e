"""Frames that other nodes tell of on /tf and /tf_static."""

from __future__ import annotations

from typing import Any

import numpy as np

from humanoid_bt.gateway.clock import EngineClock
from humanoid_bt.gateway.file import Qos
from humanoid_bt.gateway.frames import FrameTree, Transform
from humanoid_bt.gateway.node import Ears
from humanoid_bt.gateway.percepts import Malformed, quaternion, vector
from humanoid_bt.gateway.qos import profile

_MOVING = Qos(reliability="best_effort", durability="volatile", depth=100)
_FIXED = Qos(reliability="reliable", durability="transient_local", depth=100)


def listen_to_transforms(ears: Ears, frames: FrameTree, clock: EngineClock) -> None:
    """Learn frames from /tf and /tf_static."""

    def learn(message: Any, fixed: bool) -> None:
        for frame, transform in transforms(message, clock, fixed):
            frames.learn(frame, transform)

    kind = "tf2_msgs/TFMessage"
    ears.listen("/tf", kind, profile(_MOVING, _MOVING), lambda message: learn(message, False))
    ears.listen("/tf_static", kind, profile(_FIXED, _FIXED), lambda message: learn(message, True))


def transforms(message: Any, clock: EngineClock, fixed: bool) -> list[tuple[str, Transform]]:
    """Return the transforms of a message by their frames, without those that are none.

    Args:
        message: a TFMessage.
        clock: for its stamps.
        fixed: whether they are from /tf_static.
    """
    found = []
    for one in message.transforms:
        stamp = one.header.stamp.sec + one.header.stamp.nanosec * 1e-9
        try:
            turn = quaternion(one.transform.rotation)
        except Malformed:
            continue
        pose = np.array([*vector(one.transform.translation), *(turn if turn is not None else np.full(4, np.nan))])
        if np.isfinite(pose).all():
            parent = one.header.frame_id.lstrip("/")
            transform = Transform(parent, pose, None if fixed else clock.engine(stamp))
            found.append((one.child_frame_id.lstrip("/"), transform))
    return found
