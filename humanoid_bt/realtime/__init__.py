"""Realtime mode: control, decision and perception as processes of their own, joined by shared memory."""
