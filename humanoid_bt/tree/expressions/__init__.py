"""Expressions of trees: their grammar, types and units, what they can ask, and their evaluation."""
