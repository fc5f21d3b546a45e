"""Checking files: codes of findings, comments that allow them, robots that stand and walk."""
