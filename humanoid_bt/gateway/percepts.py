"""From messages of ROS 2 to what was seen: where, in which frame, when."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from humanoid_bt.core.messages import Array

_NANO = 1e-9


class Malformed(ValueError):  # noqa: N818 (the name says it)
    """A message does not say what it should."""


@dataclass(frozen=True)
class Sighting:
    """What a message says of one thing.

    Attributes:
        stamp: ROS time at which it was seen [s]; None if it does not say.
        frame: of the rest; "" if it does not say.
        position: shape (3,) [m].
        orientation: wxyz, shape (4,); None if it is not known.
        confidence: in [0, 1]; None if it does not say.
        class_name: what kind of thing it is, "" if it does not say.
        size: of the box around it, along the axes of ``orientation``, shape (3,) [m]; None if it is not known.
        covariance: of the position, shape (3, 3) [m^2]; None if it is not known.
    """

    stamp: float | None
    frame: str
    position: Array
    orientation: Array | None = None
    confidence: float | None = None
    class_name: str = ""
    size: Array | None = None
    covariance: Array | None = None


def sighting(message: Any, kind: str, class_: str, fields: Mapping[str, str]) -> Sighting | None:
    """Return what a message says of a thing, None if nothing.

    Args:
        message: it.
        kind: its type, of :data:`READERS` unless there are fields.
        class_: of several detections, which count; "" for all.
        fields: where x, y, z and perhaps confidence are in a message of any other type.

    Raises:
        Malformed: it does not say where the thing is.
    """
    if fields:
        return _by_fields(message, fields)
    return READERS[kind.replace("/msg/", "/")](message, class_)


def _pose_stamped(message: Any, _class: str) -> Sighting:
    return Sighting(*_header(message), vector(message.pose.position), quaternion(message.pose.orientation))


def _point_stamped(message: Any, _class: str) -> Sighting:
    return Sighting(*_header(message), vector(message.point))


def _pose_with_covariance(message: Any, _class: str) -> Sighting:
    pose = message.pose.pose
    return Sighting(
        *_header(message), vector(pose.position), quaternion(pose.orientation), covariance=_spread(message.pose)
    )


def _detections(message: Any, class_: str) -> Sighting | None:
    """Return the surest detection, of those of a class if one is given."""
    found = [
        (result.hypothesis.score, detection, result)
        for detection in message.detections
        for result in detection.results
        if not class_ or result.hypothesis.class_id == class_
    ]
    if not found:
        return None
    score, detection, result = max(found, key=lambda one: one[0])
    stamp, frame = _header(detection) if detection.header.frame_id else _header(message)
    size = vector(detection.bbox.size)
    boxed = bool((size > 0).all())
    pose = detection.bbox.center if boxed else result.pose.pose
    return Sighting(
        stamp,
        frame,
        vector(pose.position),
        quaternion(pose.orientation),
        float(score),
        str(result.hypothesis.class_id),
        size if boxed else None,
        _spread(result.pose),
    )


READERS: Mapping[str, Callable[[Any, str], Sighting | None]] = {
    "geometry_msgs/PoseStamped": _pose_stamped,
    "geometry_msgs/PoseWithCovarianceStamped": _pose_with_covariance,
    "geometry_msgs/PointStamped": _point_stamped,
    "vision_msgs/Detection3DArray": _detections,
}
"""The types of messages that are understood as they are."""


def _by_fields(message: Any, fields: Mapping[str, str]) -> Sighting:
    numbers = {name: _number(message, path) for name, path in fields.items()}
    stamp, frame = _header(message) if hasattr(message, "header") else (None, "")
    position = np.array([numbers["x"], numbers["y"], numbers["z"]])
    return Sighting(stamp, frame, position, confidence=numbers.get("confidence"))


def _number(message: Any, path: str) -> float:
    value = value_at(message, path)
    if isinstance(value, (str, bool)):
        raise Malformed(f"it has no number at {path!r}")
    return float(value)


def value_at(message: Any, path: str) -> float | str | bool:
    """Return a number or text of a message by its path: ``point.x``, ``data.3``.

    Raises:
        Malformed: there is none.
    """
    value = message
    try:
        for part in path.split("."):
            value = value[int(part)] if part.isdigit() else getattr(value, part)
        return value if isinstance(value, (str, bool)) else float(value)
    except (AttributeError, IndexError, TypeError, ValueError):
        raise Malformed(f"it has nothing at {path!r}") from None


def _header(message: Any) -> tuple[float | None, str]:
    """Return when a message says that it is from, None for never, and its frame."""
    stamp = message.header.stamp
    return (stamp.sec + stamp.nanosec * _NANO if stamp.sec or stamp.nanosec else None), message.header.frame_id


def vector(message: Any) -> Array:
    """Return a Point or a Vector3 as an array, shape (3,)."""
    return np.array([message.x, message.y, message.z], dtype=float)


def quaternion(message: Any) -> Array | None:
    """Return a Quaternion as wxyz, shape (4,), of length 1; None for the one of length 0, which says nothing.

    Raises:
        Malformed: it is none.
    """
    wxyz = np.array([message.w, message.x, message.y, message.z], dtype=float)
    length = float(np.linalg.norm(wxyz))
    if length == 0:
        return None
    if not abs(length - 1) < 0.01:  # a NaN too
        raise Malformed(f"its orientation has the length {length:g}: a unit quaternion has 1")
    unit: Array = wxyz / length
    return unit


def _spread(pose: Any) -> Array | None:
    """Return the covariance of the position of a PoseWithCovariance, None where it was left at zero."""
    covariance: Array = np.asarray(pose.covariance, dtype=float).reshape(6, 6)[:3, :3]
    return covariance if covariance.any() else None
