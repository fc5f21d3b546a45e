"""Detections in a camera's frame, and frames on /tf, of a real node; and the robot's own frames, which it needs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.link.wire.percepts import decode_percepts
from humanoid_bt.realtime import channels
from tests.gateway.detector import SPREAD
from tests.gateway.nodes import Peer, ball
from tests.realtime.helpers import Live, until

pytestmark = [pytest.mark.ros, pytest.mark.realtime]

DETECTOR = """
format: 1
frames: {tf: true}
percepts:
  target: {topic: /detections, type: vision_msgs/Detection3DArray, class: ball, solid: true}
publish: {tf: {}}
"""


@pytest.fixture
def detections(project: Path) -> str:
    """Name of a gateway that hears detections."""
    for package in ("vision_msgs", "tf2_msgs"):
        pytest.importorskip(package, reason=f"humanoid-bt interfaces {package} could not build it")
    (project / "gateways/detections.yaml").write_text(DETECTOR)
    return "detections"


def test_fetch_is_driven_by_detections_in_a_camera_s_frame(
    live: Callable[..., Live], peer: Peer, detections: str
) -> None:
    from tf2_msgs.msg import TFMessage

    peer.hears(TFMessage, "/tf")
    run = live("fetch", "--duration", "60", gateway=detections)
    with ball("tests.gateway.detector"):
        ring, seen = channels.reader(run.folder, "gateway_percept"), []

        def found() -> bool:
            seen.extend(decode_percepts(data).percepts for _, data in ring.since(0)[0])
            return any(seen)

        until("the ball is seen", found)
        code = run.ends()
    assert code == 0, run.output
    percept = next(one for percepts in seen for one in percepts)
    assert (percept.name, percept.class_name, percept.confidence) == ("target", "ball", 0.8)
    assert percept.size == pytest.approx([0.08] * 3)
    assert percept.covariance is not None
    assert sorted(np.linalg.eigvalsh(percept.covariance)) == pytest.approx(SPREAD)
    assert percept.covariance[2, 2] == pytest.approx(SPREAD[0])  # the camera looks down
    assert run.report["percepts"]["target"]["confidence"] == 0.8
    assert run.report["odometry"]["off"] < 0.1

    own = [one for message in peer.heard["/tf"] for one in message.transforms if one.child_frame_id == "base_link"]
    assert {one.header.frame_id for one in own} == {"odom"}
    assert own[-1].transform.translation.x > 1.0  # it walked there, from the origin


def test_what_hangs_on_a_frame_that_falls_silent_is_refused(
    live: Callable[..., Live], peer: Peer, detections: str
) -> None:
    from geometry_msgs.msg import TransformStamped
    from tf2_msgs.msg import TFMessage
    from vision_msgs.msg import Detection3D, Detection3DArray, ObjectHypothesisWithPose

    run = live("fetch", "--duration", "120", gateway=detections)
    frames, seen = peer.publisher(TFMessage, "/tf"), peer.publisher(Detection3DArray, "/detections")
    head = TransformStamped(child_frame_id="head")
    head.header.frame_id = "base_link"
    result = ObjectHypothesisWithPose()
    result.hypothesis.class_id, result.hypothesis.score, result.pose.pose.position.x = "ball", 0.7, 1.5
    message = Detection3DArray(detections=[Detection3D(results=[result])])
    message.header.frame_id = "head"

    def told(text: str, *, turns: bool) -> bool:
        message.header.stamp = head.header.stamp = peer.node.get_clock().now().to_msg()
        if turns:
            frames.publish(TFMessage(transforms=[head]))
        seen.publish(message)
        return text in run.output

    until("it is refused", lambda: told("nobody says where the frame 'head' is", turns=False))
    until("it is understood", lambda: told("messages on /detections are understood again", turns=True))
    until("it is refused again", lambda: told("where the frame 'head' is was last said 0.5 s before", turns=False))
