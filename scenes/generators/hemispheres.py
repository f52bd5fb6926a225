"""A sphere of radius 1 in two halves, above and below z = 0: an octahedron, split and rounded.

python -m harness generate --scene analytic/integrating-sphere
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from ply import write_ply

Points = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.int64]


def octant(steps: int) -> tuple[Points, Triangles]:
    """The octant x, y, z >= 0, its edges split in `steps`, wound so that normals point inwards.

    Rows run from the pole down, each along its circle of latitude in equal angles, so that the
    equator and the meridians between octants are rows of edges.
    """
    points = [(0.0, 0.0, 1.0)]
    triangles = []
    for row in range(1, steps + 1):
        polar = 0.5 * np.pi * row / steps
        angles = 0.5 * np.pi * np.arange(row + 1) / row
        ring = np.sin(polar) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        points += [(x, y, np.cos(polar)) for x, y in ring]
        above, first = row * (row - 1) // 2, row * (row + 1) // 2
        triangles += [(above + i, first + i + 1, first + i) for i in range(row)]
        triangles += [(above + i, above + i + 1, first + i + 1) for i in range(row - 1)]
    return np.array(points), np.array(triangles)


def half(steps: int, side: float) -> tuple[Points, Triangles]:
    """Half of the sphere, `side` = 1 above the equator, -1 below, with normals inwards."""
    corner, triangles = octant(steps)
    points, faces = [], []
    for quarter in range(4):
        turned = corner.copy()
        for _ in range(quarter):
            turned[:, :2] = np.stack([-turned[:, 1], turned[:, 0]], axis=1)
        turned[:, 2] *= side
        points.append(turned)
        faces.append((triangles if side > 0.0 else triangles[:, ::-1]) + quarter * len(corner))
    return np.concatenate(points), np.concatenate(faces)


def welded(points: Points, triangles: Triangles) -> tuple[Points, Triangles]:
    """One vertex where several coincide as float32, in the order of their first use."""
    rounded = np.round(points, 6) + 0.0
    _, first, index = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return points[first[order]], place[index.ravel()][triangles]


def generate(bright: Path, dark: Path, steps: int) -> None:
    """Write both halves, each of 4 `steps`^2 triangles."""
    for file, side in ((bright, 1.0), (dark, -1.0)):
        write_ply(file, *welded(*half(steps, side)))
