"""The extension's replays: which traversals it has, how it holds rays, and what it is built of."""

from typing import Any

from harness.tracers.rays import Held, Rays, Structure


def traversals() -> tuple[str, ...]:
    """Names of the extension's traversals, that of replays which name none first."""
    from haste_cuda import _core

    first = _core.default_traversal()
    return (first, *(name for name in _core.traversals() if name != first))


def hold(rays: Rays) -> Held:
    """Rays in the extension's memory, and in the GPU's from their first replay there on."""
    import haste_cuda

    held: Held = haste_cuda.Rays(rays.origins, rays.directions, rays.t_min, rays.t_max)
    return held


def structure_of(scene: Any, traversal: str) -> Structure:
    """What a traversal walks through: time of its build, [s], and size, [B]."""
    from haste_cuda import _core

    size, seconds = _core.bvh_bytes(scene, traversal), _core.bvh_build_seconds(scene, traversal)
    return Structure(float(seconds), float(size))
