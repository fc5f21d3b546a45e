"""The recording of a run and its rerun view."""
