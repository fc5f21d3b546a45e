"""What the engine costs beside baselines, how punctual it is, and what a body withstands."""
