"""A learned walker: its description, its network, and how both fit a robot."""
