"""State and targets in, setpoints of all joints out: balance, walking, inverse kinematics."""
