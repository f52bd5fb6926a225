"""Menger sponges: the cube without the middle of each face and the centre, again and again.

A sponge of level n is 20^n cubes. Its boundary is 2 * 20^n + 4 * 8^n squares, of two triangles
each; its volume is (20/27)^n of the cube's and its area 2 (20/9)^n + 4 (8/9)^n squares of the
cube's side (K. Menger, "Allgemeine Raeume und Cartesische Raeume", 1926, is where it comes from).

    python -m harness generate --scene menger-3
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from ply import write_ply

Points = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.int64]


def solid_cells(level: int) -> npt.NDArray[np.bool_]:
    """Which cells [3^level, 3^level, 3^level] are full: no digit to base 3 is 1 along two axes."""
    size = 3**level
    full = np.ones((size, size, size), bool)
    for place in range(level):
        middle = (np.arange(size) // 3**place) % 3 == 1
        x, y, z = middle[:, None, None], middle[None, :, None], middle[None, None, :]
        full &= ~((x & y) | (y & z) | (x & z))
    return full


def sponge(level: int) -> tuple[Points, Triangles]:
    """Boundary of the sponge in [-1, 1]^3, wound outwards; equal corners are one vertex."""
    full = np.pad(solid_cells(level), 1)
    quads = []
    for axis in range(3):
        u, v = np.eye(3, dtype=np.int64)[[(axis + 1) % 3, (axis + 2) % 3]]
        for side in (0, 1):
            bare = full & ~np.roll(full, -1 if side else 1, axis=axis)
            corner = np.argwhere(bare) - 1
            corner[:, axis] += side
            ring = [corner, corner + u, corner + u + v, corner + v]
            quads.append(np.stack(ring if side else ring[::-1], axis=1))
    corners = np.concatenate(quads)
    size = 3**level
    keys = corners @ np.array([(size + 1) ** 2, size + 1, 1])
    used, indices = np.unique(keys.reshape(-1), return_inverse=True)
    lattice = np.stack(np.unravel_index(used, (size + 1,) * 3), axis=1)
    triangles = indices.reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return 2.0 * lattice / size - 1.0, triangles


def generate(mesh: Path, *, level: int) -> None:
    """Write the sponge of `level` to `mesh`."""
    write_ply(mesh, *sponge(level), comment=f"Menger sponge of level {level}")
