"""Closest hits of a pinhole camera's rays in double precision, found without a ray tracer.

Every primitive is projected onto the film, and only the rays through the box of its projection are
tested against it: a rasteriser, with no hierarchy, no traversal and no padding that could be wrong
in the same way as those of the tracers. The rays are the tracers' own, single precision included,
so that what differs is the tracing alone.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.scene import Camera, Scene

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

NONE = 0xFFFFFFFF
"""Primitive of a ray that hits nothing."""

PAIRS_AT_ONCE = 1 << 20
"""Most pairs of a primitive and a ray that are tested at a time: what bounds the memory."""

MARGIN = 1
"""Pixels around the box of a projection: far more than rounding moves a ray or a corner."""


@dataclass(frozen=True, slots=True)
class Hits:
    """Closest hits, one entry a ray: t float64 [N] (infinity without one), primitive uint32 [N]."""

    t: Floats
    primitive: NDArray[np.uint32]


def closest_hits(
    scene: Scene, origins: NDArray[np.float32], directions: NDArray[np.float32]
) -> Hits:
    """Find what the rays through the corners of the scene's pixels hit first.

    Parameters
    ----------
    scene
        The scene; its camera is the one that the rays belong to.
    origins, directions
        float32 [(height + 1) * (width + 1), 3], row by row: ray (x, y) goes through the film
        position (x, y).

    Returns
    -------
    Hits
        With t in units of the directions, t > 0. Of equal distances the lower primitive counts.
    """
    rays = (origins.astype(np.float64), directions.astype(np.float64))
    best = Hits(np.full(len(origins), np.inf), np.full(len(origins), NONE, np.uint32))
    corners = scene.vertices[scene.triangles].astype(np.float64)
    _scatter(best, scene.camera, corners, 0, lambda i, k: _triangles(corners[i], rays, k))
    spheres = scene.spheres.astype(np.float64)
    offsets = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    cubes = spheres[:, None, :3] + offsets * spheres[:, None, 3:]
    _scatter(best, scene.camera, cubes, len(corners), lambda i, k: _spheres(spheres[i], rays, k))
    return best


def film_boxes(camera: Camera, hulls: Floats) -> Integers:
    """Box of the film positions at which rays may meet convex hulls.

    Parameters
    ----------
    camera
        The camera.
    hulls
        float64 [P, K, 3], the points that span each hull.

    Returns
    -------
    int64 [P, 4]
        First and last x, first and last y, within the film; the whole film for a hull that reaches
        behind the camera, an empty box (first above last) for one that lies behind it.
    """
    basis = np.stack([camera.dx, camera.dy, camera.corner], axis=1)
    local = (hulls - np.array(camera.origin)) @ np.linalg.inv(basis).T
    depth = local[..., 2]
    in_front = (depth > 0.0).all(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        film = local[..., :2] / depth[..., None]
    boxes = np.empty((len(hulls), 4), np.int64)
    for axis, size in ((0, camera.width), (1, camera.height)):
        place = np.where(in_front[:, None], film[..., axis], 0.0)
        first = np.clip(np.floor(place.min(axis=1)) - MARGIN, 0, size + 1)
        last = np.clip(np.ceil(place.max(axis=1)) + MARGIN, -1, size)
        boxes[:, 2 * axis] = np.where(in_front, first, 0)
        boxes[:, 2 * axis + 1] = np.where(in_front, last, size)
    boxes[(depth < 0.0).all(axis=1), 1] = -1
    return boxes


def _scatter(best: Hits, camera: Camera, hulls: Floats, first_primitive: int, test: object) -> None:
    """Test primitives against the rays in their boxes, and keep the closest hits in `best`."""
    assert callable(test)
    boxes = film_boxes(camera, hulls)
    widths = np.maximum(boxes[:, 1] - boxes[:, 0] + 1, 0)
    counts = widths * np.maximum(boxes[:, 3] - boxes[:, 2] + 1, 0)
    ends = np.cumsum(counts)
    total = int(ends[-1]) if len(ends) else 0
    for start in range(0, total, PAIRS_AT_ONCE):
        pair = np.arange(start, min(start + PAIRS_AT_ONCE, total))
        index = np.searchsorted(ends, pair, side="right")
        place = pair - (ends[index] - counts[index])
        x = boxes[index, 0] + place % widths[index]
        y = boxes[index, 2] + place // widths[index]
        ray = y * (camera.width + 1) + x
        t = test(index, ray)
        found = np.isfinite(t)
        _keep(best, ray[found], t[found], (first_primitive + index[found]).astype(np.uint32))


def _keep(best: Hits, ray: Integers, t: Floats, primitive: NDArray[np.uint32]) -> None:
    before = best.t[ray]
    np.minimum.at(best.t, ray, t)
    closer = best.t[ray] < before
    best.primitive[ray[closer]] = NONE
    winner = t == best.t[ray]
    np.minimum.at(best.primitive, ray[winner], primitive[winner])


def _triangles(corners: Floats, rays: tuple[Floats, Floats], ray: Integers) -> Floats:
    """Distances to triangles, infinity where they are missed.

    The sign of a ray's volume with an edge is the same, negated, from both sides of the edge, so no
    ray passes between two triangles that share it.
    """
    direction = rays[1][ray]
    a, b, c = np.moveaxis(corners - rays[0][ray][:, None], 1, 0)
    volumes = [
        np.einsum("ij,ij->i", direction, np.cross(p, q)) for p, q in ((b, c), (c, a), (a, b))
    ]
    inside = np.all([v >= 0.0 for v in volumes], axis=0) | np.all(
        [v <= 0.0 for v in volumes], axis=0
    )
    normal = np.cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.einsum("ij,ij->i", a, normal) / np.einsum("ij,ij->i", direction, normal)
    return np.where(inside & (t > 0.0), t, np.inf)


def _spheres(spheres: Floats, rays: tuple[Floats, Floats], ray: Integers) -> Floats:
    """Distances to spheres, infinity where they are missed."""
    direction = rays[1][ray]
    towards = spheres[:, :3] - rays[0][ray]
    squared = np.einsum("ij,ij->i", direction, direction)
    middle = np.einsum("ij,ij->i", towards, direction) / squared
    off_centre = towards - middle[:, None] * direction
    inner = spheres[:, 3] ** 2 - np.einsum("ij,ij->i", off_centre, off_centre)
    half = np.sqrt(np.maximum(inner, 0.0) / squared)
    t = np.where(middle - half > 0.0, middle - half, middle + half)
    return np.where((inner >= 0.0) & (t > 0.0), t, np.inf)
