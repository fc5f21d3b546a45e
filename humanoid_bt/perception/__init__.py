"""What the robot sees: sources of percepts, and the tracks they leave in the world."""
