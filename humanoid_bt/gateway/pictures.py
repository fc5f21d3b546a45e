"""What the head camera sees, as messages of ROS 2, in its optical frame: z ahead, x to the right, y down."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping
from typing import Any

from humanoid_bt.gateway.outputs import Types, stamped
from humanoid_bt.link.wire.picture import SeenPicture

Make = Callable[[Types, SeenPicture, float, str], Any]
"""Makes a message of a picture, its stamp in ROS time [s], and the name of the optical frame."""


def image(types: Types, picture: SeenPicture, stamp: float, frame: str) -> Any:
    """Return the colours."""
    return _image(picture.color, "rgb8", stamped(types("sensor_msgs/Image")(), stamp, frame))


def depth(types: Types, picture: SeenPicture, stamp: float, frame: str) -> Any:
    """Return the depths along the camera's axis [m], infinite where nothing is."""
    return _image(picture.depth, "32FC1", stamped(types("sensor_msgs/Image")(), stamp, frame))


def camera_info(types: Types, picture: SeenPicture, stamp: float, frame: str) -> Any:
    """Return how pixels and directions go together: a pinhole without distortion."""
    message = stamped(types("sensor_msgs/CameraInfo")(), stamp, frame)
    height, width = picture.depth.shape
    focal, across, down = picture.focal, (width - 1) / 2, (height - 1) / 2
    message.height, message.width = height, width
    message.distortion_model, message.d = "plumb_bob", [0.0] * 5
    message.k = [focal, 0.0, across, 0.0, focal, down, 0.0, 0.0, 1.0]
    message.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    message.p = [focal, 0.0, across, 0.0, 0.0, focal, down, 0.0, 0.0, 0.0, 1.0, 0.0]
    return message


def _image(pixels: Any, encoding: str, message: Any) -> Any:
    height, width = pixels.shape[:2]
    message.height, message.width, message.encoding = height, width, encoding
    message.is_bigendian, message.step = 0, pixels[0].nbytes
    message.data = array("B", pixels.tobytes())
    return message


MAKE: Mapping[str, Make] = {"image": image, "depth": depth, "camera_info": camera_info}
"""What is made of every picture, by its key in the gateway file."""
