"""Where frames of ROS 2 are, seen from the robot's base."""

from __future__ import annotations

import math
import threading
from collections import deque
from dataclasses import dataclass

import numpy as np

from humanoid_bt.core.geometry import pose_inverse, pose_product, quaternion
from humanoid_bt.core.messages import Array
from humanoid_bt.gateway.file import Frames
from humanoid_bt.link.wire.picture import SeenPicture

_PAST = 100  # base poses that are remembered: 2 s at 50 Hz

_FRESH = 0.5  # s for which a transform of /tf counts
_OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""From a camera's optical frame (z ahead, x right, y down) to the eye's (x ahead, y left, z up)."""

_HERE = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


class NotYetKnown(ValueError):  # noqa: N818 (the name says it)
    """The run has just begun: control has not said yet where the robot is."""


class UnknownFrame(ValueError):  # noqa: N818 (the name says it)
    """Nobody has said where a frame is."""


@dataclass(frozen=True)
class Transform:
    """A frame in its parent.

    Attributes:
        parent: the other frame.
        pose: of the frame there, shape (7,): position [m], orientation wxyz.
        stamp: engine time from which it is [s]; None for one that does not move.
    """

    parent: str
    pose: Array
    stamp: float | None = None


class FrameTree:
    """Knows the frames that files and /tf tell of. From any thread.

    Args:
        config: what frames are called, and which do not move.
    """

    def __init__(self, config: Frames) -> None:
        self._base, self._odom = config.base, config.odom
        self._lock = threading.Lock()
        self._past: deque[tuple[float, Array]] = deque(maxlen=_PAST)
        self._known = {
            name: Transform(frame.parent, np.array([*frame.position, *_unit(frame.orientation)]))
            for name, frame in config.fixed.items()
        }

    def base_at(self, time: float, position: Array, orientation: Array) -> None:
        """Take where the base is in the engine's world at an engine time [s]."""
        with self._lock:
            self._past.append((time, np.array([*position, *orientation])))

    def learn(self, frame: str, transform: Transform) -> None:
        """Take where a frame is; it is not asked for the base and the world, of which control knows better."""
        with self._lock:
            self._known[frame] = transform

    def in_base(self, frame: str, time: float) -> Array:
        """Return a frame's pose in the robot's base frame at an engine time [s], shape (7,).

        Raises:
            UnknownFrame: nobody has said where it is, or not lately though it moves.
            NotYetKnown: it hangs on the engine's world, and the run has just begun.
        """
        with self._lock:
            pose, name, way = _HERE, frame.lstrip("/"), set[str]()
            while name not in (self._base, self._odom):
                known = self._known.get(name)
                if known is None or name in way:
                    hung = f", on which {frame!r} hangs" if name != frame.lstrip("/") else ""
                    raise UnknownFrame(f"nobody says where the frame {name!r} is{hung}")
                if known.stamp is not None and time - known.stamp > _FRESH:
                    raise UnknownFrame(f"where the frame {name!r} is was last said {time - known.stamp:.1f} s before")
                way.add(name)
                pose, name = pose_product(known.pose, pose), known.parent.lstrip("/")
            return pose if name == self._base else pose_product(pose_inverse(self._base_pose(time)), pose)

    def _base_pose(self, time: float) -> Array:
        if not self._past:
            raise NotYetKnown("the robot has not said yet where it is")
        return min(self._past, key=lambda past: abs(past[0] - time))[1]


def optical_in_base(picture: SeenPicture) -> tuple[Array, Array]:
    """Return where a picture's optical frame is in the base frame: position, (3,) [m], and quaternion wxyz, (4,)."""
    return picture.position, quaternion(picture.rotation @ _OPTICAL)


def _unit(orientation: tuple[float, ...]) -> list[float]:
    length = math.hypot(*orientation)
    return [value / length for value in orientation]
