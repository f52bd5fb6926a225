"""Rays at the places where cracks open: edges, vertices, and a few ulp beside them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.stability.rings import Integers, Rings, Vertices
from harness.tracers.rays import Rays, make_rays

Floats = NDArray[np.float64]

AIMS = ("edge", "vertex", "beside_edge", "beside_vertex")
"""What rays are aimed at, as in the key `aim` of harness/schemas/keys.yaml."""

MOST_ULP = 4
"""By how many ulp a component of the direction is moved beside the aim, at most."""

NEAREST_END = 1.0 / 16.0
"""Share of an edge at either end that is not aimed at: that is left to the vertices."""


@dataclass(frozen=True, slots=True)
class Mesh:
    """A mesh with its rings.

    vertices: float32 [V, 3]; triangles: uint32 [T, 3]. normals: float64 [V, 3], pointing outwards
    where the mesh is wound so, of any length.
    """

    vertices: Vertices
    triangles: NDArray[np.uint32]
    normals: Floats
    centre: Floats
    radius: float
    """half the diagonal of the box"""

    @classmethod
    def of(cls, vertices: Vertices, triangles: NDArray[np.uint32]) -> "Mesh":
        """Take the measures of a mesh."""
        used = vertices[np.unique(triangles)].astype(np.float64)
        low, high = used.min(axis=0), used.max(axis=0)
        corners = vertices[triangles].astype(np.float64)
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.zeros((len(vertices), 3))
        for corner in range(3):
            np.add.at(normals, triangles[:, corner], faces)
        radius = 0.5 * float(np.linalg.norm(high - low))
        return cls(vertices, triangles, normals, 0.5 * (low + high), radius)


def aimed_rays(
    mesh: Mesh, rings: Rings, count: int, *, eye: float, beside: bool, random: np.random.Generator
) -> tuple[Rays, Integers]:
    """Rays at edges or vertices from the side that their normals point to.

    Parameters
    ----------
    mesh
        The mesh.
    rings
        What is aimed at, drawn evenly.
    count
        Rays.
    eye
        Distance of the origins from the mesh's centre, in its radii.
    beside
        Whether directions are moved by up to `MOST_ULP` ulp, each component on its own.
    random
        Generator.

    Returns
    -------
    The rays, of unit length but for rounding, and the ring that each is aimed at, int64 [count].
    """
    ring = random.integers(0, len(rings), count)
    ends = rings.ends[ring]
    share = random.uniform(NEAREST_END, 1.0 - NEAREST_END, (count, 1))
    a, b = mesh.vertices[ends[:, 0]].astype(np.float64), mesh.vertices[ends[:, 1]]
    target = a + share * (b - a)
    away = random.normal(size=(count, 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    normal = mesh.normals[ends[:, 0]] + mesh.normals[ends[:, 1]]
    away[np.einsum("ij,ij->i", away, normal) < 0.0] *= -1.0
    origins = (mesh.centre + eye * mesh.radius * away).astype(np.float32)
    towards = target - origins
    # An eye within the box may lie on what it is aimed at.
    length = np.linalg.norm(towards, axis=1, keepdims=True)
    towards = np.where(length > 0.0, towards, -away) / np.where(length > 0.0, length, 1.0)
    directions = towards.astype(np.float32)
    if beside:
        directions = _moved(directions, random)
    return make_rays(origins, directions), ring


def _moved(directions: NDArray[np.float32], random: np.random.Generator) -> NDArray[np.float32]:
    """Directions with each component 1 to `MOST_ULP` ulp up or down."""
    step = random.integers(1, MOST_ULP + 1, directions.shape)
    step *= random.choice([-1, 1], directions.shape)
    return directions + step.astype(np.float32) * np.spacing(np.abs(directions))
