"""What the engine costs beside baselines, and how punctual and quick it is in realtime mode."""
