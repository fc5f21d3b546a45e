"""The recording of a run, and how the viewer shows it."""
