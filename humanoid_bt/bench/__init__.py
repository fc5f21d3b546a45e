"""Measurements of the engine: its cost beside baselines, and how punctual and quick it is in realtime mode."""
