"""Bumpy spheres: one closed surface at any number of triangles, for benchmarks of traversal.

The radius is r(U, V) = 1 + 0.1 sin(20 U) sin(20 V) + 0.02 sin(97 U + 3) cos(83 V), U being the
angle about the axis and V that from it. The points are n rings of 2n, closed by a point at each
pole: 4 n^2 triangles, none of them degenerate.

    python -m harness generate --scene bumpy-16k
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from ply import write_ply

Points = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.int64]


def radius(u: Points, v: Points) -> Points:
    """Distance of the surface from the centre in the direction of the angles u and v."""
    waves = 0.1 * np.sin(20.0 * u) * np.sin(20.0 * v)
    return 1.0 + waves + 0.02 * np.sin(97.0 * u + 3.0) * np.cos(83.0 * v)


def bumpy_sphere(rings: int) -> tuple[Points, Triangles]:
    """Points [2 n^2 + 2, 3] and triangles [4 n^2, 3] of the sphere of n rings, wound outwards."""
    around = 2 * rings
    v, u = np.meshgrid(
        np.pi * (np.arange(rings) + 1.0) / (rings + 1.0),
        2.0 * np.pi * np.arange(around) / around,
        indexing="ij",
    )
    direction = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1)
    body = (radius(u, v)[..., None] * direction).reshape(-1, 3)
    # At a pole every U is the same point, whose radius is the mean over them.
    points = np.concatenate([body, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    place = np.arange(rings * around).reshape(rings, around)
    beside = np.roll(place, -1, axis=1)
    north, south = np.full(around, len(body)), np.full(around, len(body) + 1)
    near, far = place[:-1], beside[:-1]
    below, across = place[1:], beside[1:]
    parts = [
        np.stack([north, place[0], beside[0]], axis=-1),
        np.stack([near, below, across], axis=-1).reshape(-1, 3),
        np.stack([near, across, far], axis=-1).reshape(-1, 3),
        np.stack([south, beside[-1], place[-1]], axis=-1),
    ]
    return points, np.concatenate(parts)


def generate(mesh: Path, *, rings: int) -> None:
    """Write the sphere of so many rings to `mesh`."""
    write_ply(mesh, *bumpy_sphere(rings), comment=f"Bumpy sphere of {rings} rings")
