"""What the engine costs beside baselines, how punctual it is, and what a robot's body withstands."""
