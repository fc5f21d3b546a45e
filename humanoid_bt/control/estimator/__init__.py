"""Readings in, what control believes out: contact, base pose and velocity, failed sensors."""
