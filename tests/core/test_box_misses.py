"""No hierarchy hides a hit: rays at the corners and faces of boxes, along their axes and within
their planes, find what testing every triangle finds."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from core_meshes import Triangles, Vertices, mesh_scene, star
from numpy.typing import NDArray

import haste_cuda
from haste_cuda import _core

HIERARCHIES = [name for name in _core.traversals() if name != "brute_force"]
PATTERNS = [signs for signs in product((-1.0, 0.0, 1.0), repeat=3) if any(signs)]
"""Of the signs of a direction; the 27th is no direction."""
COUNT = 20_000
Rays = tuple[NDArray[np.float32], ...]


def blocks(count: int, seed: int) -> tuple[Vertices, Triangles]:
    """Axis-parallel boxes on a lattice, some of them flat: faces lie in the planes of slabs."""
    random = np.random.default_rng(seed)
    low = random.integers(-4, 4, (count, 1, 3))
    size = random.integers(0, 4, (count, 1, 3))
    corners = low + size * np.array(list(product((0, 1), repeat=3)))[None]
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
    faces += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
    triangles = 8 * np.arange(count)[:, None, None] + np.array(faces)[None]
    return corners.reshape(-1, 3).astype(np.float32), triangles.reshape(-1, 3)


MESHES = {"star": star(5), "blocks": blocks(20, 4)}


def adversarial(vertices: Vertices, triangles: Triangles, count: int, seed: int) -> Rays:
    """Rays from and to points on the planes of slabs, at corners of boxes, with slopes of nothing,
    of next to nothing and of one."""
    random = np.random.default_rng(seed)
    corners = vertices[triangles]
    chosen = random.integers(0, len(triangles), count)
    low, high = corners.min(axis=1)[chosen], corners.max(axis=1)[chosen]
    side = random.integers(0, 2, (count, 3)).astype(bool)
    target = np.where(side, high, low)
    inner = random.random((count, 3)) < 0.3
    target = np.where(inner, low + random.random((count, 3)) * (high - low), target)
    size = np.linalg.norm(vertices.max(axis=0) - vertices.min(axis=0))
    slope = random.choice([0.0, -0.0, 1.0, -1.0, 1e-8, -1e-8, 1e-20, 1e-38], (count, 3))
    loose = random.random(count) < 0.5
    slope[loose] = random.normal(size=(int(loose.sum()), 3))
    slope[~slope.any(axis=1)] = [0.0, 0.0, 1.0]
    distance = size * random.choice([0.0, 0.5, 1.0, 100.0], (count, 1))
    origins = target - distance * slope
    t_max = np.full(count, np.inf)
    arrays = (origins, slope, np.zeros(count), t_max)
    return tuple(np.ascontiguousarray(array, np.float32) for array in arrays)


def patterned(vertices: Vertices, pattern: tuple[float, ...], zero: float, seed: int) -> Rays:
    """Rays of one pattern of signs from corners of the mesh, on its planes, within its box and
    outside of it."""
    random = np.random.default_rng(seed)
    count = 600
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    inside = random.uniform(low, high, (count, 3))
    corner = vertices[random.integers(0, len(vertices), count)]
    mixed = np.where(random.random((count, 3)) < 0.5, inside, corner)
    sign = np.array(pattern)
    origins = np.concatenate([inside, corner, mixed, mixed - 20.0 * sign])
    size = random.uniform(0.1, 1.0, (len(origins), 3))
    size[::2] = 1.0
    towards = np.where(sign == 0.0, zero, sign * size)
    arrays = (origins, towards, np.zeros(len(origins)), np.full(len(origins), np.inf))
    return tuple(np.ascontiguousarray(array, np.float32) for array in arrays)


def hidden(
    scene: haste_cuda.Scene, rays: Rays, traversal: str, precision: str = "watertight"
) -> tuple[NDArray[np.bool_], int]:
    """Rays that a hierarchy answers in another way than the list of all triangles, and hits."""
    truth = haste_cuda.trace_cpu(scene, *rays, traversal="brute_force", precision=precision)
    found = haste_cuda.trace_cpu(scene, *rays, traversal=traversal, precision=precision)
    wrong = (found["t"] != truth["t"]) | (found["primitive"] != truth["primitive"])
    return wrong, int(np.isfinite(truth["t"]).sum())


@pytest.mark.parametrize("traversal", HIERARCHIES)
@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_no_box_that_holds_a_hit_is_missed(name: str, traversal: str, scale: float) -> None:
    vertices, triangles = MESHES[name]
    vertices = (vertices.astype(np.float64) * scale).astype(np.float32)
    rays = adversarial(vertices, triangles, COUNT, 11)
    wrong, hits = hidden(mesh_scene(vertices, triangles), rays, traversal)
    first = int(np.argmax(wrong))
    assert hits > 0.1 * COUNT
    assert not wrong.any(), (
        f"{wrong.sum()} of {COUNT}, the first {[array[first].tolist() for array in rays]}"
    )


def test_boxes_without_padding_are_caught() -> None:
    """Negative control: the same rays find what the plain slab test loses."""
    vertices, triangles = MESHES["star"]
    rays = adversarial(vertices, triangles, COUNT, 11)
    wrong, _ = hidden(mesh_scene(vertices, triangles), rays, "bvh2", "fast")
    assert wrong.any()


@pytest.mark.parametrize("zero", [0.0, -0.0])
@pytest.mark.parametrize("name", MESHES)
def test_every_pattern_of_signs_and_zeros_equals_brute_force(name: str, zero: float) -> None:
    vertices, triangles = MESHES[name]
    scene = mesh_scene(vertices, triangles)
    for number, pattern in enumerate(PATTERNS):
        rays = patterned(vertices, pattern, zero, number)
        for traversal in HIERARCHIES:
            wrong, hits = hidden(scene, rays, traversal)
            assert hits > 0, pattern
            assert not wrong.any(), f"{traversal}, direction {pattern}: {wrong.sum()} rays"


def test_a_direction_of_zeros_is_refused() -> None:
    """The 27th pattern."""
    scene = mesh_scene(*MESHES["star"])
    zeros = np.zeros((1, 3), np.float32)
    with pytest.raises(ValueError, match="ray 0: its direction is zero"):
        haste_cuda.trace_cpu(scene, zeros, zeros, np.zeros(1, np.float32), np.ones(1, np.float32))
