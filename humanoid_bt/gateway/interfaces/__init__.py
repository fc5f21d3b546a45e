"""Packages of ROS 2 messages, built as wheels for a ROS 2 that came from wheels itself."""
