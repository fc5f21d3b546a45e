"""Stand-ins for messages of ROS 2, for tests that have none."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any


def header(stamp: float = 0.0, frame: str = "") -> SimpleNamespace:
    seconds = int(stamp)
    return SimpleNamespace(stamp=SimpleNamespace(sec=seconds, nanosec=round((stamp - seconds) * 1e9)), frame_id=frame)


def vector(x: float, y: float, z: float) -> SimpleNamespace:
    return SimpleNamespace(x=x, y=y, z=z)


def turn(w: float = 1.0, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> SimpleNamespace:
    return SimpleNamespace(w=w, x=x, y=y, z=z)


def pose(position: Any, orientation: Any = None) -> SimpleNamespace:
    return SimpleNamespace(position=position, orientation=orientation or turn())


def pose_stamped(
    stamp: float, position: tuple[float, float, float], frame: str = "", orientation: Any = None
) -> SimpleNamespace:
    return SimpleNamespace(header=header(stamp, frame), pose=pose(vector(*position), orientation))


def detection(class_: str, score: float, position: tuple[float, float, float], size: float = 0.0) -> SimpleNamespace:
    where = pose(vector(*position))
    hypothesis = SimpleNamespace(class_id=class_, score=score)
    result = SimpleNamespace(hypothesis=hypothesis, pose=SimpleNamespace(pose=where, covariance=[0.0] * 36))
    box = SimpleNamespace(center=where, size=vector(size, size, size))
    return SimpleNamespace(header=header(), results=[result], bbox=box)


def transform(parent: str, child: str, stamp: float, position: tuple[float, float, float]) -> SimpleNamespace:
    moved = SimpleNamespace(translation=vector(*position), rotation=turn())
    return SimpleNamespace(header=header(stamp, parent), child_frame_id=child, transform=moved)
