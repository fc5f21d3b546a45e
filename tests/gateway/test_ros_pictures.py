"""The head camera's pictures, as other nodes get them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.gateway.nodes import Peer
from tests.perception.opengl import opengl
from tests.realtime.helpers import Live, until

__all__ = ["opengl"]
pytestmark = [pytest.mark.ros, pytest.mark.realtime]

EYE = "format: 1\npublish: {image: {}, depth: {topic: /far}, camera_info: {}}\n"
WATCH = "format: 1\nscene: still\nroot: {wait: 1000 s}\n"
STILL = """
format: 1
name: still
objects:
  ball: {shape: ball, size: [8 cm], color: orange, position: [1.9, 0.5, 0.85], stand: true}
percepts:
  target: {object: ball}
"""


@pytest.mark.usefixtures("opengl")
def test_pictures_are_published_as_often_as_a_source_looks(
    live: Callable[..., Live], peer: Peer, project: Path
) -> None:
    from sensor_msgs.msg import CameraInfo, Image

    (project / "trees/watch.yaml").write_text(WATCH)
    (project / "sim/scenes").mkdir(parents=True, exist_ok=True)
    (project / "sim/scenes/still.yaml").write_text(STILL)
    (project / "gateways/eye.yaml").write_text(EYE)
    peer.hears(Image, "/camera/image_raw")
    peer.hears(Image, "/far")
    peer.hears(CameraInfo, "/camera/camera_info")
    live("watch", "--perception", "color_blob", gateway="eye")
    until("pictures", lambda: all(len(of) > 5 for of in peer.heard.values()))
    color, far, info = (peer.heard[topic][-1] for topic in ("/camera/image_raw", "/far", "/camera/camera_info"))
    assert {message.header.frame_id for message in (color, far, info)} == {"head_camera_optical_frame"}
    assert (color.encoding, far.encoding) == ("rgb8", "32FC1")
    assert (color.width, color.height) == (far.width, far.height) == (info.width, info.height)
    pixels = np.frombuffer(bytes(color.data), np.uint8).reshape(color.height, color.width, 3).astype(int)
    orange = (pixels[..., 0] > 120) & (pixels[..., 0] - pixels[..., 2] > 80)  # the ball on its stand
    assert orange.any()
    depths = np.frombuffer(bytes(far.data), "<f4").reshape(far.height, far.width)
    assert 1.0 < np.median(depths[orange]) < 3.0  # it is 1.9 m away
    stamps = [message.header.stamp.sec + message.header.stamp.nanosec * 1e-9 for message in peer.heard["/far"]]
    assert min(np.diff(stamps)) > 0.15  # the source looks 5 times a second


def test_without_a_source_that_looks_it_is_told_that_there_are_no_pictures(
    live: Callable[..., Live], project: Path
) -> None:
    (project / "trees/watch.yaml").write_text(WATCH)
    (project / "sim/scenes").mkdir(parents=True, exist_ok=True)
    (project / "sim/scenes/still.yaml").write_text(STILL)
    (project / "gateways/eye.yaml").write_text(EYE)
    run = live("watch", gateway="eye")
    until("it is told", lambda: "no percept source of this run looks with the head camera" in run.output)
