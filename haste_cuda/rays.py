"""Rays for their own sake: once as four arrays, or held for any number of replays."""

from __future__ import annotations

from typing import Any

from haste_cuda import _core


def held(*rays: Any) -> _core.Rays:
    """The `Rays` that are given, or those of four arrays. Raises ValueError naming a ray."""
    return rays[0] if len(rays) == 1 else _core.Rays(*rays)


def trace_cpu(scene: _core.Scene, *rays: Any, **how: Any) -> dict[str, Any]:
    """Trace rays on the processor: see `_core.trace_cpu`, whose keywords these are.

    rays: `Rays`, or the arrays that they are made of. Raises ValueError naming the ray that makes
    no sense.
    """
    return _core.trace_cpu(scene, held(*rays), **how)


def trace_embree(scene: _core.Scene, *rays: Any, **how: Any) -> dict[str, Any]:
    """Trace rays through Embree's hierarchy: see `_core.trace_embree`, whose keywords these are.

    rays: `Rays`, or the arrays that they are made of. Raises ValueError naming the ray that makes
    no sense, or saying why Embree has no such packets.
    """
    return _core.trace_embree(scene, held(*rays), **how)
