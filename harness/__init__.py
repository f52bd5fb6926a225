"""The benchmark around the tracers: scenes in, tables and pictures out."""

from harness.scene import load_scene

__all__ = ["load_scene"]
