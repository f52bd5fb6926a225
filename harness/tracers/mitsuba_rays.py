"""Ray queries through Mitsuba: all at once in vectorised variants, one by one in scalar ones."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.tracers.rays import NONE, Query, RayHits, Rays

Raw = tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.uint32], tuple[float, ...]]
"""t, place of the shape in Mitsuba's list, primitive within it, seconds of each repeat."""


@dataclass(frozen=True, slots=True)
class HeldRays:
    """Rays as a variant takes them: one `Ray3f` of all in vectorised variants, else arrays.

    Mitsuba's rays start at their origin: with a t_min that is not 0 the origin is moved along the
    ray, in single precision.
    """

    t_min: NDArray[np.float32]
    rays: Any

    def __len__(self) -> int:
        return len(self.t_min)


@dataclass(frozen=True, slots=True)
class _Moved:
    """origins, directions: float32 [N, 3]; reach: float32 [N]."""

    origins: NDArray[np.float32]
    directions: NDArray[np.float32]
    reach: NDArray[np.float32]


def hold(rays: Rays) -> HeldRays:
    """Hand rays to the current variant of Mitsuba."""
    import mitsuba as mi

    origins, reach = rays.origins, rays.t_max
    if rays.t_min.any():
        later = rays.t_min[:, None]
        origins = np.where(later > 0.0, origins + later * rays.directions, origins)
        reach = reach - rays.t_min
    moved = _Moved(origins, rays.directions, reach)
    scalar = mi.variant().startswith("scalar")
    return HeldRays(rays.t_min, moved if scalar else _at_once(moved))


def trace(
    scene: Any,
    first: NDArray[np.uint32],
    dropped: Mapping[int, NDArray[np.uint32]],
    rays: HeldRays,
    query: Query,
) -> RayHits:
    """Trace rays through a Mitsuba scene of the current variant.

    Parameters
    ----------
    scene
        Mitsuba's scene.
    first
        uint32 [shapes], number of each shape's first primitive in the import's order, `NONE` where
        Mitsuba's shape is not made of the import's primitives.
    dropped
        Triangles of Mitsuba's that the import has not, uint32, ascending, by the shape's number.
    rays
        The rays, held by the same variant.
    query
        What is asked of them.
    """
    ask = _trace_one_by_one if isinstance(rays.rays, _Moved) else _trace_at_once
    t, shape, local, times = ask(scene, rays.rays, query)
    hit = np.isfinite(t)
    if query.any_hit:
        return RayHits(np.where(hit, np.float32(0.0), t), _nowhere(t), _nowhere(t), times)
    shape = np.where(hit, shape, NONE)
    local = local.copy()
    for number, gone in dropped.items():
        own = shape == number
        local[own] -= np.searchsorted(gone, local[own]).astype(np.uint32)
    base = np.full(len(t), NONE)
    base[hit] = first[shape[hit]]
    primitive = np.where(base != NONE, base + np.where(hit, local, np.uint32(0)), NONE)
    return RayHits(t + rays.t_min[: len(t)], shape, primitive.astype(np.uint32), times)


def _nowhere(t: NDArray[np.float32]) -> NDArray[np.uint32]:
    return np.full(len(t), NONE)


def _at_once(rays: _Moved) -> Any:
    """All rays as one, in the memory of the variant."""
    import drjit as dr
    import mitsuba as mi

    ray = mi.Ray3f(mi.Point3f(rays.origins.T), mi.Vector3f(rays.directions.T))
    ray.maxt = mi.Float(rays.reach)
    dr.eval(ray)
    dr.sync_thread()
    return ray


def _trace_at_once(scene: Any, ray: Any, query: Query) -> Raw:
    import drjit as dr
    import mitsuba as mi

    times = []
    # The history holds the kernels' own times: no Python, no tracing of the program, no copies.
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for _ in range(query.repeats):
            dr.kernel_history_clear()
            if query.any_hit:
                found = [dr.select(scene.ray_test(ray), mi.Float(0.0), mi.Float(math.inf))]
            else:
                hit = scene.ray_intersect_preliminary(ray)
                owner = dr.reinterpret_array(mi.UInt32, hit.shape)
                there = dr.select(hit.is_valid(), hit.t, mi.Float(math.inf))
                found = [there, owner, hit.prim_index]
            dr.eval(*found)
            dr.sync_thread()
            kernels = dr.kernel_history()
            times.append(1e-3 * sum(float(kernel["execution_time"]) for kernel in kernels))
    t = found[0].numpy() if query.hits else np.zeros(0, np.float32)
    if query.any_hit or not query.hits:
        return t, _nowhere(t), _nowhere(t), tuple(times)
    # Mitsuba numbers shapes by a registry of the whole process, in which a scene's come in order.
    registered = dr.reinterpret_array(mi.UInt32, scene.shapes_dr()).numpy()
    order = np.argsort(registered)
    places = np.searchsorted(registered[order], found[1].numpy())
    shape = order[np.minimum(places, len(order) - 1)].astype(np.uint32)
    return t, shape, found[2].numpy(), tuple(times)


def _trace_one_by_one(scene: Any, rays: _Moved, query: Query) -> Raw:
    """Scalar variants take one ray a call: their time would be Python's, so none is given,
    and they are traced once.
    """
    import mitsuba as mi

    count = len(rays.origins)
    t = np.full(count, np.inf, np.float32)
    shape, local = np.full(count, NONE), np.full(count, NONE)
    parts = (rays.origins.tolist(), rays.directions.tolist(), rays.reach.tolist())
    ray = mi.Ray3f()
    for index, (origin, direction, farthest) in enumerate(zip(*parts, strict=True)):
        ray.o, ray.d, ray.maxt = origin, direction, farthest
        if query.any_hit:
            if scene.ray_test(ray):
                t[index] = 0.0
            continue
        hit = scene.ray_intersect_preliminary(ray)
        if hit.is_valid():
            t[index], shape[index], local[index] = hit.t, hit.shape_index, hit.prim_index
    return t, shape, local, (math.nan,) * query.repeats
