"""Ticking a tree: every kind of node alike, one snapshot in, one command out."""
