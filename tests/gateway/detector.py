"""A detector in ROS 2, until it is killed: a camera on a head that turns, surer of a lamp than of the ball.

It is told where the ball is in the frame odom [m], hears on /tf where the robot's base is, and publishes the head's
frame on /tf, the camera's on /tf_static, and what the camera sees.
"""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np

from humanoid_bt.core.geometry import pose_inverse, pose_product

SPREAD = (1e-4, 4e-4, 9e-4)
"""Variances of where the ball is, along the axes of the camera [m^2]."""

_LENS = np.array([0.1, 0.0, 0.05, math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0])  # in the head: looks down
_RATE = 30  # Hz


def main() -> None:
    import rclpy
    from geometry_msgs.msg import TransformStamped
    from rclpy.node import Node
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from tf2_msgs.msg import TFMessage
    from vision_msgs.msg import Detection3D, Detection3DArray, ObjectHypothesisWithPose

    ball = np.array([*map(float, sys.argv[1:]), 1.0, 0.0, 0.0, 0.0])

    class Detector(Node):
        def __init__(self) -> None:
            super().__init__("detector")
            self._base: Any = None
            self._turns = 0
            self._moving = self.create_publisher(TFMessage, "/tf", 100)
            latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            self._fixed = self.create_publisher(TFMessage, "/tf_static", latched)
            self._fixed.publish(TFMessage(transforms=[self._transform("head", "lens", _LENS)]))
            self._seen = self.create_publisher(Detection3DArray, "/detections", 10)
            self.create_subscription(TFMessage, "/tf", self._learn, 100)
            self.create_timer(1 / _RATE, self._look)

        def _transform(self, parent: str, child: str, pose: Any) -> Any:
            told = TransformStamped(child_frame_id=child)
            told.header.frame_id, told.header.stamp = parent, self.get_clock().now().to_msg()
            put(told.transform.translation, told.transform.rotation, pose)
            return told

        def _learn(self, message: Any) -> None:
            for told in message.transforms:
                if (told.header.frame_id, told.child_frame_id) == ("odom", "base_link"):
                    place, turn = told.transform.translation, told.transform.rotation
                    self._base = np.array([place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z])

        def _look(self) -> None:
            self._turns += 1
            yaw = 0.5 * math.sin(self._turns / _RATE)
            head = np.array([0.0, 0.0, 0.6, math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])
            told = self._transform("base_link", "head", head)
            self._moving.publish(TFMessage(transforms=[told]))
            if self._base is None:
                return
            seen = pose_product(pose_inverse(pose_product(pose_product(self._base, head), _LENS)), ball)
            message = Detection3DArray(
                detections=[detection("ball", 0.8, seen, 0.08), detection("lamp", 0.9, _LENS, 0.3)]
            )
            message.header.frame_id, message.header.stamp = "lens", told.header.stamp
            self._seen.publish(message)

    def detection(class_: str, score: float, pose: Any, size: float) -> Any:
        found, result = Detection3D(id=f"the {class_}"), ObjectHypothesisWithPose()
        result.hypothesis.class_id, result.hypothesis.score = class_, score
        put(result.pose.pose.position, result.pose.pose.orientation, pose)
        covariance = np.zeros((6, 6))
        covariance[:3, :3] = np.diag(SPREAD)
        result.pose.covariance = covariance.ravel()
        put(found.bbox.center.position, found.bbox.center.orientation, pose)
        found.bbox.size.x = found.bbox.size.y = found.bbox.size.z = size
        found.results = [result]
        return found

    rclpy.init()
    rclpy.spin(Detector())


def put(place: Any, turn: Any, pose: Any) -> None:
    """Write a pose, shape (7,), into a message's point or vector, and its quaternion."""
    place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z = map(float, pose)


if __name__ == "__main__":
    main()
