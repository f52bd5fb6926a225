"""Closed meshes and scenes made of arrays, for tests of the core."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import haste_cuda

Vertices = NDArray[np.float32]
Triangles = NDArray[np.uint32]


CAMERA = haste_cuda.Camera(
    origin=(0, 0, 5),
    corner=(-1, 1, -1),
    dx=(0.1, 0, 0),
    dy=(0, -0.1, 0),
    near=0.01,
    width=20,
    height=20,
)
"""Looks down the z axis from (0, 0, 5); 20 x 20 pixels."""


def star(rings: int = 24, seed: int = 1) -> tuple[Vertices, Triangles]:
    """A closed star-shaped mesh of 2 * rings * (2 * rings - 2) triangles with a rough radius."""
    sectors = 2 * rings
    random = np.random.default_rng(seed)
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = np.arange(sectors) * 2 * np.pi / sectors
    t, p = np.meshgrid(theta, phi, indexing="ij")
    radius = random.uniform(0.5, 1.0, t.shape)
    ring = (
        np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1) * radius[..., None]
    )
    vertices = np.vstack([ring.reshape(-1, 3), [[0, 0, 0.9], [0, 0, -0.9]]]).astype(np.float32)
    index = np.arange(ring.shape[0] * sectors).reshape(ring.shape[0], sectors)
    right = np.roll(index, -1, axis=1)
    north, south = len(vertices) - 2, len(vertices) - 1
    triangles = [
        np.stack([index[:-1], index[1:], right[1:]], -1).reshape(-1, 3),
        np.stack([index[:-1], right[1:], right[:-1]], -1).reshape(-1, 3),
        np.stack([np.full(sectors, north), index[0], right[0]], -1),
        np.stack([np.full(sectors, south), right[-1], index[-1]], -1),
    ]
    return vertices, np.vstack(triangles).astype(np.uint32)


def mesh_scene(
    vertices: Vertices,
    triangles: Triangles,
    spheres: list[tuple[float, float, float, float]] | None = None,
    threads: int = 1,
) -> haste_cuda.Scene:
    """A scene of one mesh and some spheres, one shape each, without lights."""
    spheres = spheres or []
    shapes = []
    if len(triangles):
        shapes.append(haste_cuda.Shape(kind="mesh", material=0, first=0, count=len(triangles)))
    first_sphere = len(shapes)
    shapes += [
        haste_cuda.Shape(kind="sphere", material=0, first=i, count=1) for i in range(len(spheres))
    ]
    return haste_cuda.Scene(
        vertices=np.ascontiguousarray(vertices, dtype=np.float32).reshape(-1, 3),
        normals=np.zeros((len(vertices), 3), np.float32),
        triangles=np.ascontiguousarray(triangles, dtype=np.uint32).reshape(-1, 3),
        triangle_shape=np.zeros(len(triangles), np.uint32),
        spheres=np.array(spheres, np.float32).reshape(-1, 4),
        sphere_shape=np.arange(first_sphere, first_sphere + len(spheres), dtype=np.uint32),
        shapes=shapes,
        materials=[haste_cuda.Material(diffuse=(0.5, 0.5, 0.5))],
        lights=[],
        camera=CAMERA,
        threads=threads,
    )


def directions(count: int, seed: int) -> NDArray[np.float32]:
    """Uniform unit vectors, shape [count, 3]."""
    v = np.random.default_rng(seed).normal(size=(count, 3))
    return (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)
