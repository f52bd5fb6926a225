"""Measurement: one job a scene, one process a tracer, everything kept as files."""
