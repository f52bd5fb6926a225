"""The tracers under test: one interface, one line each in the registry."""

from harness.tracers.base import RayCounts, RenderResult, Tracer, UnsupportedError
from harness.tracers.rays import NONE, RayHits
from harness.tracers.registry import COLOURS, TRACERS, load_tracer

__all__ = [
    "COLOURS",
    "NONE",
    "TRACERS",
    "RayCounts",
    "RayHits",
    "RenderResult",
    "Tracer",
    "UnsupportedError",
    "load_tracer",
]
