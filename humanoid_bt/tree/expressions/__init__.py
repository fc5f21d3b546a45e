"""Expressions of trees: grammar, types and units, what they can ask, and their evaluation."""
