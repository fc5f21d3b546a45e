"""Checking files without running them: codes of findings, comments that allow them."""
