"""Packages of messages, services and actions, built as wheels for a ROS 2 that was itself installed from wheels."""
