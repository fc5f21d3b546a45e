"""Realtime mode: control, decision and perception in processes that share memory."""
