"""Checking files: whether a robot stands and walks, codes of findings, and comments that allow them."""
