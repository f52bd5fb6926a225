"""The tracers under test: one interface, one line each in the registry."""

from harness.tracers.base import RayCounts, RenderResult, Tracer, UnsupportedError
from harness.tracers.registry import COLOURS, TRACERS, load_tracer

__all__ = [
    "COLOURS",
    "TRACERS",
    "RayCounts",
    "RenderResult",
    "Tracer",
    "UnsupportedError",
    "load_tracer",
]
