"""Where frames of ROS 2 are, seen from the robot's base."""

from __future__ import annotations

import math
import threading
from bisect import bisect_left
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from humanoid_bt.core.geometry import pose_inverse, pose_product, quaternion, turn_between, turned
from humanoid_bt.core.messages import Array
from humanoid_bt.gateway.file import Frames
from humanoid_bt.link.wire.picture import SeenPicture

_PAST = 200  # poses of a frame that are remembered: the base's of 4 s at 50 Hz
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
        self._past = _Past()
        self._known = {
            name: (frame.parent, _Past([(math.inf, np.array([*frame.position, *_unit(frame.orientation)]))]))
            for name, frame in config.fixed.items()
        }

    def base_at(self, time: float, position: Array, orientation: Array) -> None:
        """Take where the base is in the engine's world at an engine time [s]."""
        with self._lock:
            self._past.add(time, np.array([*position, *orientation]))

    def learn(self, frame: str, transform: Transform) -> None:
        """Take where a frame is; it is not asked for the base in the world, of which control knows better."""
        with self._lock:
            parent, past = self._known.get(frame, ("", _Past()))
            if transform.stamp is None or parent != transform.parent or past.fixed:
                past = _Past()
            past.add(math.inf if transform.stamp is None else transform.stamp, transform.pose)
            self._known[frame] = transform.parent, past

    def in_base(self, frame: str, time: float) -> Array:
        """Return a frame's pose in the robot's base frame at an engine time [s], shape (7,).

        Raises:
            UnknownFrame: nobody has said where it is, or not lately though it moves.
            NotYetKnown: it hangs on the engine's world, and the run has just begun.
        """
        with self._lock:
            below = [self._base, self._odom]
            while (known := self._known.get(below[-1])) and known[0] not in below:
                below.append(known[0])  # what the engine's world itself hangs on: a map
            pose, name, way = _HERE, frame.lstrip("/"), set[str]()
            while name not in below:
                known = self._known.get(name)
                if known is None or name in way:
                    hung = f", on which {frame!r} hangs" if name != frame.lstrip("/") else ""
                    raise UnknownFrame(f"nobody says where the frame {name!r} is{hung}")
                way.add(name)
                pose, name = pose_product(self._pose(name, time), pose), known[0]
            base = _HERE
            for child in below[: below.index(name)]:
                base = pose_product(self._pose(child, time), base)
            return pose_product(pose_inverse(base), pose)

    def _pose(self, frame: str, time: float) -> Array:
        """Return where a frame is in its parent at an engine time [s]."""
        if frame == self._base:
            if not self._past:
                raise NotYetKnown("the robot has not said yet where it is")
            return self._past.at(time)
        past = self._known[frame][1]
        if (silent := time - past.latest) > _FRESH:
            raise UnknownFrame(f"where the frame {frame!r} is was last said {silent:.1f} s before")
        return past.at(time)


class _Past:
    """Where a frame has been in its parent lately.

    Args:
        poses: engine times [s], infinity for one that does not move, and poses, shape (7,).
    """

    def __init__(self, poses: Iterable[tuple[float, Array]] = ()) -> None:
        self._poses = deque(poses, maxlen=_PAST)

    def __bool__(self) -> bool:
        return bool(self._poses)

    @property
    def latest(self) -> float:
        """Time of the last pose [s]."""
        return self._poses[-1][0]

    @property
    def fixed(self) -> bool:
        """Whether it does not move."""
        return bool(self._poses) and math.isinf(self.latest)

    def add(self, time: float, pose: Array) -> None:
        """Take a pose; those of later times were a mistake, of a clock that has been set since."""
        while self._poses and self.latest >= time:
            self._poses.pop()
        self._poses.append((time, pose))

    def at(self, time: float) -> Array:
        """Return the pose at a time [s]: between two poses on the way from one to the other, else the nearest."""
        times = [past for past, _ in self._poses]
        after = bisect_left(times, time)
        if after in (0, len(times)):
            return self._poses[min(after, len(times) - 1)][1]
        (begin, start), (end, goal) = self._poses[after - 1], self._poses[after]
        share = (time - begin) / (end - begin)
        turn = turned(start[3:], share * turn_between(start[3:], goal[3:]))
        return np.array([*(start[:3] + share * (goal[:3] - start[:3])), *turn])


def optical_in_base(picture: SeenPicture) -> tuple[Array, Array]:
    """Return where a picture's optical frame is in the base frame: position, (3,) [m], and quaternion wxyz, (4,)."""
    return picture.position, quaternion(picture.rotation @ _OPTICAL)


def _unit(orientation: tuple[float, ...]) -> list[float]:
    length = math.hypot(*orientation)
    return [value / length for value in orientation]
