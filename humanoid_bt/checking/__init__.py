"""Checking files: codes of findings, comments that allow them, robots that are tried."""
