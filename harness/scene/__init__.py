"""Scenes: Mitsuba XML (or a Mitsuba scene dictionary) read into plain arrays that any tracer can
take.

Mitsuba's own parser reads the file and Mitsuba's own plugins build the geometry, so a scene means
here what it means there. What the tracers cannot render is refused, all of it, in one `SceneError`.
Mitsuba is imported on the first call, not with this package.
"""

from harness.scene.checks import check_model
from harness.scene.errors import SceneError
from harness.scene.features import Features
from harness.scene.importer import load_scene
from harness.scene.parse import SceneSource, parse_scene
from harness.scene.records import Camera, Light, Material, Scene, Shape
from harness.scene.settings import RenderSettings, Settings, load_settings
from harness.scene.variant import active_variant, mitsuba_errors, parser_config

__all__ = [
    "Camera",
    "Features",
    "Light",
    "Material",
    "RenderSettings",
    "Scene",
    "SceneError",
    "SceneSource",
    "Settings",
    "Shape",
    "active_variant",
    "check_model",
    "load_scene",
    "load_settings",
    "mitsuba_errors",
    "parse_scene",
    "parser_config",
]
