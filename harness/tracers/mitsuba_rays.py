"""Ray queries through Mitsuba: all at once in vectorised variants, one by one in scalar ones."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.tracers.rays import NONE, RayHits, Rays

Raw = tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.uint32], tuple[float, ...]]
"""t, place of the shape in Mitsuba's list, primitive within it, seconds of each repeat."""


def trace(
    scene: Any,
    first: NDArray[np.uint32],
    dropped: Mapping[int, NDArray[np.uint32]],
    rays: Rays,
    *,
    any_hit: bool,
    repeats: int = 1,
) -> RayHits:
    """Trace rays through a Mitsuba scene of the current variant.

    Mitsuba's rays start at their origin: with a t_min that is not 0 the origin is moved along the
    ray, in single precision.

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
        The rays.
    any_hit
        Whether any hit will do.
    repeats
        How often they are traced.
    """
    import mitsuba as mi

    moved = np.where(
        rays.t_min[:, None] > 0.0,
        rays.origins + rays.t_min[:, None] * rays.directions,
        rays.origins,
    )
    reach = rays.t_max - rays.t_min
    query = _trace_one_by_one if mi.variant().startswith("scalar") else _trace_at_once
    t, shape, local, times = query(
        scene, moved, rays.directions, reach, any_hit=any_hit, repeats=repeats
    )
    hit = np.isfinite(t)
    if any_hit:
        return RayHits(np.where(hit, np.float32(0.0), t), _nowhere(t), _nowhere(t), times)
    shape = np.where(hit, shape, NONE)
    local = local.copy()
    for number, gone in dropped.items():
        own = shape == number
        local[own] -= np.searchsorted(gone, local[own]).astype(np.uint32)
    base = np.full(len(t), NONE)
    base[hit] = first[shape[hit]]
    primitive = np.where(base != NONE, base + np.where(hit, local, np.uint32(0)), NONE)
    return RayHits(t + rays.t_min, shape, primitive.astype(np.uint32), times)


def _nowhere(t: NDArray[np.float32]) -> NDArray[np.uint32]:
    return np.full(len(t), NONE)


def _trace_at_once(
    scene: Any,
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    reach: NDArray[np.float32],
    *,
    any_hit: bool,
    repeats: int,
) -> Raw:
    import drjit as dr
    import mitsuba as mi

    ray = mi.Ray3f(mi.Point3f(origins.T), mi.Vector3f(directions.T))
    ray.maxt = mi.Float(reach)
    dr.eval(ray)
    dr.sync_thread()
    times = []
    # The history holds the kernels' own times: no Python, no tracing of the program, no copies.
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for _ in range(repeats):
            dr.kernel_history_clear()
            if any_hit:
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
    t = found[0].numpy()
    if any_hit:
        return t, _nowhere(t), _nowhere(t), tuple(times)
    # Mitsuba numbers shapes by a registry of the whole process, in which a scene's come in order.
    registered = dr.reinterpret_array(mi.UInt32, scene.shapes_dr()).numpy()
    order = np.argsort(registered)
    places = np.searchsorted(registered[order], found[1].numpy())
    shape = order[np.minimum(places, len(order) - 1)].astype(np.uint32)
    return t, shape, found[2].numpy(), tuple(times)


def _trace_one_by_one(
    scene: Any,
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    reach: NDArray[np.float32],
    *,
    any_hit: bool,
    repeats: int,
) -> Raw:
    """Scalar variants take one ray a call: their time would be Python's, so none is given,
    and they are traced once.
    """
    import mitsuba as mi

    count = len(origins)
    t = np.full(count, np.inf, np.float32)
    shape, local = np.full(count, NONE), np.full(count, NONE)
    rays = zip(origins.tolist(), directions.tolist(), reach.tolist(), strict=True)
    ray = mi.Ray3f()
    for index, (origin, direction, farthest) in enumerate(rays):
        ray.o, ray.d, ray.maxt = origin, direction, farthest
        if any_hit:
            if scene.ray_test(ray):
                t[index] = 0.0
            continue
        hit = scene.ray_intersect_preliminary(ray)
        if hit.is_valid():
            t[index], shape[index], local[index] = hit.t, hit.shape_index, hit.prim_index
    return t, shape, local, (math.nan,) * repeats
