"""Behavior trees: their language, their nodes, how they are checked, ticked and shown."""
