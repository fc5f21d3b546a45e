"""Campaigns: one tree run many times, what came of it, and whether that is more than chance."""
