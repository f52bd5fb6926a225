"""Whether rays pass between the triangles of a mesh that has no gap: cracks.

A ray is aimed at an edge or a vertex that triangles surround, its ring. Whether it meets one of
these is decided exactly (reference/exact_hits.py). Where it does, a tracer must see a triangle of
the ring or something before it; else the ray has passed through a crack.

Rays at an outline are left out: where the ring, seen along the ray, does not lie around it but
folds back, single precision may see the ray on either side, and both are right. The rim of the ring
tells: where it winds around the ray, and passes it at more than the rounding of single precision,
the ring covers the ray wherever in that rounding each vertex is taken to be, so that it is the same
place for all triangles.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.stability.aims import Mesh
from harness.stability.rings import Booleans, Integers, Rings
from harness.tracers.rays import Rays
from reference.brute_force import ROUNDING
from reference.exact_hits import meets

Floats = NDArray[np.float64]

QUANTILES = (0.5, 0.999)
"""Of the errors of distances, those that are published."""

PAIRS_AT_ONCE = 1 << 14
"""Pairs of a ray and a triangle that are looked at together: they stay in a processor's cache."""


@dataclass(frozen=True, slots=True)
class Truth:
    """What rays meet of the rings that they are aimed at, one entry a ray.

    met: whether the ray meets the ring, exactly. covered: whether it also would if every vertex lay
    somewhat off; no tracer may lose such a ray. end: float64, where the ring lies behind.
    """

    met: Booleans
    covered: Booleans
    end: Floats


def truth_of(mesh: Mesh, rings: Rings, rays: Rays, ring: Integers) -> Truth:
    """Decide what rays meet.

    Parameters
    ----------
    mesh, rings
        The mesh, and the rings that rays are aimed at.
    rays
        The rays.
    ring
        int64 [N], the ring of each.
    """
    count = len(rays)
    met, covered, end = np.zeros(count, bool), np.zeros(count, bool), np.zeros(count)
    mean = len(rings.triangle) / max(len(rings), 1)
    block = max(1, int(PAIRS_AT_ONCE / mean))
    for start in range(0, count, block):
        part = np.arange(start, min(start + block, count))
        pair, ray, first = _pairs(rings, ring, part)
        covered[part], end[part] = _rim(mesh, rays, rings, pair, ray, first)
        # What is covered is met: only the others need be decided.
        met[part] = True
        rest = part[~covered[part]]
        if len(rest):
            pair, ray, first = _pairs(rings, ring, rest)
            corners = mesh.vertices[mesh.triangles[rings.triangle[pair]]]
            exact = meets(corners, rays.origins[ray], rays.directions[ray])
            met[rest] = np.logical_or.reduceat(exact, first)
    return Truth(met, covered, end)


def _pairs(rings: Rings, ring: Integers, rays: Integers) -> tuple[Integers, Integers, Integers]:
    """Places in `rings.triangle`, their rays, and where each ray's begin."""
    place, begin = rings.pairs_of(ring[rays])
    return place, np.repeat(rays, np.diff(begin)), begin[:-1]


def _rim(
    mesh: Mesh, rays: Rays, rings: Rings, pair: Integers, ray: Integers, first: Integers
) -> tuple[Booleans, Floats]:
    """Whether the rims wind around their rays, clear of them and ahead of the origin, and where
    the rings end.
    """
    d = np.ascontiguousarray(rays.directions[ray].T, np.float64)
    length = _length(d)
    d /= length
    points = _corners(mesh, rings.triangle[pair], rays.origins[ray])
    along = np.stack([(p * d).sum(axis=0) for p in points])
    blur = ROUNDING * np.max([np.abs(p).max(axis=0) for p in points], axis=0)
    across = [p - s * d for p, s in zip(points, along, strict=True)]
    angle, near = np.zeros(len(ray)), np.full(len(ray), np.inf)
    for side in range(3):
        on_rim = rings.rim[pair, side]
        a, b = across[side], across[(side + 1) % 3]
        turn = np.arctan2((d * _cross(a, b)).sum(axis=0), (a * b).sum(axis=0))
        angle += np.where(on_rim, turn, 0.0)
        near = np.where(on_rim, np.minimum(near, _distance(a, b)), near)
    winds = np.abs(np.add.reduceat(angle, first)) > np.pi
    sure = (near > 2.0 * blur) & (along.min(axis=0) > 2.0 * blur)
    covered = winds & np.logical_and.reduceat(sure, first)
    end = np.maximum.reduceat((along.max(axis=0) + blur) / length, first)
    return covered, end


def _corners(mesh: Mesh, triangle: Integers, origins: NDArray[np.float32]) -> list[Floats]:
    """The corners of triangles from origins, [3, N] each."""
    start = np.ascontiguousarray(origins.T, np.float64)
    index = mesh.triangles[triangle]
    return [
        np.ascontiguousarray(mesh.vertices[index[:, corner]].T, np.float64) - start
        for corner in range(3)
    ]


def _distance(a: Floats, b: Floats) -> Floats:
    """Distance of the segments from a to b from the origin."""
    side = b - a
    with np.errstate(invalid="ignore"):
        share = np.clip(-(a * side).sum(axis=0) / (side * side).sum(axis=0), 0.0, 1.0)
    # A segment that is seen along its length has no direction.
    return _length(a + np.nan_to_num(share) * side)


def _cross(a: Floats, b: Floats) -> Floats:
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _length(a: Floats) -> Floats:
    return np.sqrt((a * a).sum(axis=0))


def lost(
    rings: Rings,
    ring: Integers,
    truth: Truth,
    t: NDArray[np.float32],
    primitive: NDArray[np.uint32],
) -> Booleans:
    """Rays that meet their ring and were seen to hit neither it nor anything before it.

    Parameters
    ----------
    rings, ring, truth
        What the rays are aimed at, and what they meet.
    t, primitive
        float32 and uint32 [N], what a tracer saw.
    """
    late = truth.met & ~(t <= truth.end)
    suspects = np.flatnonzero(late)
    place, begin = rings.pairs_of(ring[suspects])
    own = rings.triangle[place] == np.repeat(primitive[suspects].astype(np.int64), np.diff(begin))
    if len(suspects):
        late[suspects[np.logical_or.reduceat(own, begin[:-1])]] = False
    return late


def distance_errors(
    mesh: Mesh, rays: Rays, t: NDArray[np.float32], primitive: NDArray[np.uint32]
) -> Floats:
    """How far the distances of hits are from those in double precision, one a hit, in ulp.

    Both are of the plane of the triangle that was hit; what remains of the error of single
    precision is magnified where a ray grazes it.
    """
    hit = np.flatnonzero(np.isfinite(t))
    d = np.ascontiguousarray(rays.directions[hit].T, np.float64)
    a, b, c = _corners(mesh, primitive[hit].astype(np.int64), rays.origins[hit])
    normal = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        exact = (a * normal).sum(axis=0) / (d * normal).sum(axis=0)
        return np.abs(t[hit] - exact) / np.spacing(np.abs(exact).astype(np.float32))


def false_hits(
    mesh: Mesh, rays: Rays, t: NDArray[np.float32], primitive: NDArray[np.uint32]
) -> Booleans:
    """Hits that double precision denies beyond the rounding of single precision.

    Either the ray passes by the triangle, or it meets its plane elsewhere.
    """
    wrong = np.zeros(len(rays), bool)
    hit = np.flatnonzero(np.isfinite(t))
    for start in range(0, len(hit), PAIRS_AT_ONCE):
        ray = hit[start : start + PAIRS_AT_ONCE]
        d = np.ascontiguousarray(rays.directions[ray].T, np.float64)
        a, b, c = _corners(mesh, primitive[ray].astype(np.int64), rays.origins[ray])
        blur = ROUNDING * np.max([np.abs(p).max(axis=0) for p in (a, b, c)], axis=0)
        # The volume d . (p x q) is the distance of the ray from the line pq, times both lengths
        # as seen along each other.
        volumes = [(d * _cross(p, q)).sum(axis=0) for p, q in ((a, b), (b, c), (c, a))]
        margins = [blur * _length(d) * _length(q - p) for p, q in ((a, b), (b, c), (c, a))]
        least = np.min([v + m for v, m in zip(volumes, margins, strict=True)], axis=0)
        most = np.max([v - m for v, m in zip(volumes, margins, strict=True)], axis=0)
        normal = _cross(b - a, c - a)
        height = np.abs((normal * (t[ray] * d - a)).sum(axis=0))
        wrong[ray] = ((least < 0.0) & (most > 0.0)) | (height > blur * _length(normal))
    return wrong
