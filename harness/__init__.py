"""The benchmark around the tracers: scenes in, tables and pictures out."""

from harness.scene import SceneError, load_scene

__all__ = ["SceneError", "load_scene"]
