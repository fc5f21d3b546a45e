"""What the robot sees: sources of percepts, and where they are in the world."""
