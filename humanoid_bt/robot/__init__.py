"""What a robot is: its robot.yaml, and its model compiled from MJCF."""
