"""Meshes of the hard scene: writes scenes/hard/assets/*.ply.

python scenes/generators/hard.py
"""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
from ply import quads, write_ply

ASSETS = Path(__file__).parents[1] / "hard" / "assets"

Points = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.int64]

STRIP_SEGMENTS = 7
STRIP_BEND = math.radians(250.0)
NORMAL_TILT = math.radians(40.0)


def bent_strip(segments: int, bend: float) -> tuple[Points, Triangles]:
    """A strip along x from -1 to 1, bent to an arc of radius 1 that is open at the top.

    Normals point away from the axis. Flat faces, no vertex normals.
    """
    angles = -math.pi / 2 + bend * (np.arange(segments + 1) / segments - 0.5)
    y, z = np.cos(angles), np.sin(angles)
    corners = [
        [(-1, y[i], z[i]), (1, y[i], z[i]), (1, y[i + 1], z[i + 1]), (-1, y[i + 1], z[i + 1])]
        for i in range(segments)
    ]
    points, triangles = quads(corners)
    first = points[triangles[0]]
    outwards = np.cross(first[1] - first[0], first[2] - first[0]) @ (first[0] * [0, 1, 1])
    return points, triangles if outwards > 0 else triangles[:, ::-1]


def fanned_quad(tilt: float) -> tuple[Points, Triangles, Points]:
    """The square [-1, 1]^2 at z = 0, its corners' normals tilted outwards by `tilt`.

    Shading normals that leave the geometric one far behind, on a surface that hides nothing of
    itself.
    """
    points, triangles = quads([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    normals = points * (math.tan(tilt) / math.sqrt(2)) + [0, 0, 1]
    return points, triangles, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def icosphere() -> tuple[Points, Triangles]:
    """The icosahedron of radius 1 with each face split into four: 42 vertices, 80 triangles."""
    golden = (1 + math.sqrt(5)) / 2
    vertices = [
        point
        for a in (-1, 1)
        for b in (-golden, golden)
        for point in ((0, a, b), (a, b, 0), (b, 0, a))
    ]
    points = np.array(vertices, float)
    points /= np.linalg.norm(points[0])
    edge = np.linalg.norm(points[:, None] - points[None], axis=2)
    shortest = edge[edge > 0].min() * 1.01
    near = (edge > 0) & (edge < shortest)
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    corners = list(points)
    middles: dict[tuple[int, int], int] = {}

    def middle(i: int, j: int) -> int:
        key = (min(i, j), max(i, j))
        if key not in middles:
            point = corners[i] + corners[j]
            middles[key] = len(corners)
            corners.append(point / np.linalg.norm(point))
        return middles[key]

    split = []
    for i, j, k in faces:
        a, b, c = middle(i, j), middle(j, k), middle(k, i)
        split += [(i, a, c), (j, b, a), (k, c, b), (a, b, c)]
    sphere = np.array(corners)
    triangles = np.array(split)
    tips = sphere[triangles]
    normals = np.cross(tips[:, 1] - tips[:, 0], tips[:, 2] - tips[:, 0])
    inwards = np.einsum("tx,tx->t", normals, tips.mean(axis=1)) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return sphere, triangles


def main(folder: Path = ASSETS) -> None:
    """Write the assets into `folder`."""
    write_ply(folder / "bent_strip.ply", *bent_strip(STRIP_SEGMENTS, STRIP_BEND))
    points, triangles, normals = fanned_quad(NORMAL_TILT)
    write_ply(folder / "fanned_quad.ply", points, triangles, normals=normals)
    points, triangles = icosphere()
    write_ply(folder / "icosphere.ply", points, triangles, normals=points)


if __name__ == "__main__":
    main()
