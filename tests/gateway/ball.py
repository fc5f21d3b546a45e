"""A detector in ROS 2: publishes where a ball is, given as arguments in the frame odom [m], until it is killed."""

from __future__ import annotations

import sys
import time


def main() -> None:
    import rclpy
    from geometry_msgs.msg import PoseStamped

    rclpy.init()
    node = rclpy.create_node("ball_detector")
    publisher = node.create_publisher(PoseStamped, "/ball", 10)
    message = PoseStamped()
    message.header.frame_id = "odom"
    position = message.pose.position
    position.x, position.y, position.z = map(float, sys.argv[1:])
    while True:
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)
        time.sleep(0.05)


if __name__ == "__main__":
    main()
