"""What a ray hits, in double precision: every primitive against every ray, and no hierarchy.

Triangles by Möller and Trumbore (1997). Most pairs of a ray and a triangle are far apart, and are
sorted out first by the volumes that the ray spans with the triangle's edges, which are products of
Plücker coordinates: one matrix product for all of them, with a margin far beyond its rounding.

Single precision may decide a ray either way that passes by an edge, or whose hit lies at an end of
its interval. Such rays are `ambiguous`: nobody is judged by them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.scene import Scene
from harness.tracers.rays import Rays

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]

NONE = 0xFFFFFFFF
"""Primitive of a ray that hits nothing."""

PAIRS_AT_ONCE = 1 << 16
"""Most pairs of a ray and a triangle in one matrix product: what bounds the memory."""

ROUNDING = 8 * 2.0**-24
"""What single precision may be off, as a share of the largest coordinate that takes part.

Eight roundings: half of the distance by which spawned rays are kept off their surfaces, so that a
ray is not ambiguous for the surface that it starts from.
"""

MARGIN = 2.0**-40
"""Rounding of a product of Plücker coordinates, as a share of its factors, with much to spare."""


@dataclass(frozen=True, slots=True)
class Truth:
    """What rays hit, one entry a ray.

    t: float64 [N], closest hit, infinity without one. primitive: uint32 [N], of equal distances the
    lower one. ambiguous: bool [N].
    """

    t: Floats
    primitive: NDArray[np.uint32]
    ambiguous: Booleans


@dataclass(frozen=True, slots=True)
class _Pairs:
    """Rays and primitives that meet, or nearly so, one entry a pair."""

    ray: Integers
    primitive: Integers
    t: Floats
    doubt: Floats
    """what t may be off in single precision"""
    inside: Booleans
    near_edge: Booleans


def closest_hits(scene: Scene, rays: Rays) -> Truth:
    """Find the closest hit of every ray within (t_min, t_max].

    Its time grows with rays times primitives, some nanoseconds each; its memory does not.
    """
    parts = (_triangle_pairs(scene, rays), *_sphere_pairs(scene, rays))
    pairs = _Pairs(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in _Pairs.__slots__)
    )
    low = rays.t_min.astype(np.float64)[pairs.ray]
    high = rays.t_max.astype(np.float64)[pairs.ray]
    within = pairs.inside & (pairs.t > low) & (pairs.t <= high)
    t = np.full(len(rays), np.inf)
    np.minimum.at(t, pairs.ray[within], pairs.t[within])
    primitive = np.full(len(rays), NONE, np.int64)
    winner = within & (pairs.t == t[pairs.ray])
    np.minimum.at(primitive, pairs.ray[winner], pairs.primitive[winner])
    with np.errstate(invalid="ignore"):
        at_end = np.fmin(np.abs(pairs.t - low), np.abs(pairs.t - high)) <= pairs.doubt
    # What may be a hit or not matters where it is not behind a hit.
    matters = (pairs.t <= t[pairs.ray] + pairs.doubt) & (pairs.t >= low - pairs.doubt)
    matters &= pairs.t <= high + pairs.doubt
    ambiguous = np.zeros(len(rays), bool)
    ambiguous[pairs.ray[matters & (pairs.near_edge | (at_end & pairs.inside))]] = True
    return Truth(t, primitive.astype(np.uint32), ambiguous)


def _double(rays: Rays) -> tuple[Floats, Floats]:
    return rays.origins.astype(np.float64), rays.directions.astype(np.float64)


def _triangle_pairs(scene: Scene, rays: Rays) -> _Pairs:
    corners = scene.vertices[scene.triangles].astype(np.float64)
    origin, direction = _double(rays)
    found = [(np.zeros(0, np.int64), np.zeros(0, np.int64))]
    if len(corners) and len(rays):
        # About the middle of the scene coordinates are smallest, and so is what is rounded.
        centre = 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))
        block = max(1, PAIRS_AT_ONCE // len(rays))
        for start in range(0, len(corners), block):
            part = corners[start : start + block] - centre
            ray, triangle = _near(part, origin - centre, direction)
            found.append((ray, triangle + start))
    ray, triangle = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return _moeller_trumbore(corners[triangle], origin[ray], direction[ray], ray, triangle)


def _near(corners: Floats, origin: Floats, direction: Floats) -> tuple[Integers, Integers]:
    """Pairs (ray, triangle) whose line passes through the triangle, or by it closely."""
    lines = np.concatenate([direction, np.cross(origin, direction)], axis=1)
    volumes = []
    for a, b in ((0, 1), (1, 2), (2, 0)):
        p, q = corners[:, a], corners[:, b]
        volumes.append(lines @ np.concatenate([np.cross(p, q), q - p], axis=1).T)
    reach = np.linalg.norm(corners, axis=2).max(axis=1)
    length = np.linalg.norm(direction, axis=1)[:, None]
    scale = np.linalg.norm(origin, axis=1)[:, None] + reach
    # Twice as much as makes a hit doubtful, and what the products themselves are off.
    margin = 2.0 * ROUNDING * scale * length * _longest_edge(corners)
    margin += MARGIN * length * scale * (reach + scale)
    least = np.minimum(np.minimum(volumes[0], volumes[1]), volumes[2])
    most = np.maximum(np.maximum(volumes[0], volumes[1]), volumes[2])
    ray, triangle = np.nonzero((least >= -margin) | (most <= margin))
    return ray, triangle


def _longest_edge(corners: Floats) -> Floats:
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)


def _moeller_trumbore(
    corners: Floats, origin: Floats, direction: Floats, ray: Integers, triangle: Integers
) -> _Pairs:
    """Intersections of pairs of a ray and a triangle (Möller and Trumbore 1997, section 2)."""
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    towards = origin - corners[:, 0]
    p, q = np.cross(direction, edge2), np.cross(towards, edge1)
    determinant = np.einsum("ij,ij->i", edge1, p)
    scale = np.maximum(np.abs(corners).max(axis=(1, 2)), np.abs(origin).max(axis=1))
    area = np.linalg.norm(np.cross(edge1, edge2), axis=1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        u = np.einsum("ij,ij->i", towards, p) / determinant
        v = np.einsum("ij,ij->i", direction, q) / determinant
        t = np.einsum("ij,ij->i", edge2, q) / determinant
        # A corner that moves by the rounding moves the hit by that over the cosine of incidence.
        doubt = ROUNDING * scale * area / np.abs(determinant)
        edge = ROUNDING * scale * np.linalg.norm(direction, axis=1) * _longest_edge(corners)
        edge /= np.abs(determinant)
    least = np.minimum(np.minimum(u, v), 1.0 - u - v)
    # A ray within the plane of a triangle, and a triangle without an area, are never hit.
    real = np.isfinite(t) & np.isfinite(least)
    return _Pairs(
        ray=ray,
        primitive=triangle,
        t=np.where(real, t, np.inf),
        doubt=np.where(real, doubt, 0.0),
        inside=real & (least >= 0.0),
        near_edge=real & (np.abs(least) <= edge),
    )


def _sphere_pairs(scene: Scene, rays: Rays) -> list[_Pairs]:
    origin, direction = _double(rays)
    squared = np.einsum("ij,ij->i", direction, direction)
    parts = []
    for index, (x, y, z, radius) in enumerate(scene.spheres.astype(np.float64)):
        towards = np.array([x, y, z]) - origin
        middle = np.einsum("ij,ij->i", towards, direction) / squared
        off_centre = towards - middle[:, None] * direction
        inner = radius**2 - np.einsum("ij,ij->i", off_centre, off_centre)
        scale = np.maximum(np.abs(towards).max(axis=1), radius)
        edge = 2.0 * ROUNDING * scale * scale
        ray = np.flatnonzero(inner >= -edge)
        half = np.sqrt(np.maximum(inner[ray], 0.0) / squared[ray])
        with np.errstate(divide="ignore"):
            # Half of the chord is a square root, whose relative error is half of its argument's.
            doubt = 0.5 * edge[ray] / (half * squared[ray])
        parts += [
            _Pairs(
                ray=ray,
                primitive=np.full(len(ray), len(scene.triangles) + index),
                t=middle[ray] + side * half,
                doubt=doubt,
                inside=inner[ray] >= 0.0,
                near_edge=np.abs(inner[ray]) <= edge[ray],
            )
            for side in (-1.0, 1.0)
        ]
    return parts
