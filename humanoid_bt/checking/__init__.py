"""Checking files without running them: codes of findings, and comments that allow them."""
