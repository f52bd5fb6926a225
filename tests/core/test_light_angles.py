"""Directions towards lights: their density is that of the light's solid angle, near and far."""

from __future__ import annotations

import numpy as np
import pytest
from core_meshes import CAMERA
from haste_cuda._core import testing
from numpy.typing import NDArray

import haste_cuda

DISTANCES = [10.0**power for power in range(-1, 7)]
COUNT = 4096
TOLERANCE = 2e-6
Floats = NDArray[np.float64]


def scene_with_light(kind: str) -> haste_cuda.Scene:
    """A unit sphere at (3, -2, 5), or a triangle there, that shines."""
    sphere = kind == "sphere"
    corners = np.array([[3.0, -2.0, 5.0], [4.0, -2.0, 5.1], [3.0, -1.0, 5.3]], np.float32)
    return haste_cuda.Scene(
        vertices=np.zeros((0, 3), np.float32) if sphere else corners,
        normals=np.zeros((0 if sphere else 3, 3), np.float32),
        triangles=np.zeros((0, 3), np.uint32) if sphere else np.array([[0, 1, 2]], np.uint32),
        triangle_shape=np.zeros(0 if sphere else 1, np.uint32),
        spheres=np.array([[3.0, -2.0, 5.0, 1.0]] if sphere else [], np.float32).reshape(-1, 4),
        sphere_shape=np.zeros(1 if sphere else 0, np.uint32),
        shapes=[
            haste_cuda.Shape(
                kind="sphere" if sphere else "mesh", material=0, first=0, count=1, light=0
            )
        ],
        materials=[haste_cuda.Material(diffuse=(0.5, 0.5, 0.5))],
        lights=[(0, (1.0, 1.0, 1.0))],
        camera=CAMERA,
    )


def numbers(seed: int) -> NDArray[np.float32]:
    return np.random.default_rng(seed).random((COUNT, 3)).astype(np.float32)


def around(centre: Floats, distance: float, seed: int) -> NDArray[np.float32]:
    away = np.random.default_rng(seed).normal(size=(COUNT, 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    return (centre + distance * away).astype(np.float32)


@pytest.mark.parametrize("distance", DISTANCES)
def test_the_density_towards_a_sphere_is_one_over_its_solid_angle(distance: float) -> None:
    """From its surface on: 2 pi (1 - cos), in double precision from the same point."""
    centre = np.array([3.0, -2.0, 5.0])
    start = around(centre, 1.0 + distance, 1)
    _, pdf = testing.light_directions(scene_with_light("sphere"), 0, start, numbers(2))
    squared = ((start.astype(np.float64) - centre) ** 2).sum(axis=1)
    sine_squared = 1.0 / squared
    angle = 2.0 * np.pi * sine_squared / (1.0 + np.sqrt(1.0 - sine_squared))
    off = np.abs(pdf.astype(np.float64) * angle - 1.0)
    assert off.max() <= TOLERANCE, f"{distance:g}: {off.max():.3g} from {start[off.argmax()]}"


def solid_angle(corners: Floats, start: Floats) -> Floats:
    """Of a triangle from points (Van Oosterom and Strackee 1983, equation 8)."""
    a, b, c = (corner - start for corner in corners)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    volume = np.abs((a * np.cross(b - a, c - a)).sum(axis=1))
    below = la * lb * lc + (a * b).sum(axis=1) * lc + (a * c).sum(axis=1) * lb
    return 2.0 * np.arctan2(volume, below + (b * c).sum(axis=1) * la)


@pytest.mark.parametrize("distance", DISTANCES)
def test_the_density_towards_a_triangle_is_distance_squared_over_its_turned_area(
    distance: float,
) -> None:
    """Each density is right to 2e-6 at the point that it was drawn for, and over the triangle they
    give its solid angle: exactly where it is so far that they are all alike.
    """
    corners = np.array([[3.0, -2.0, 5.0], [4.0, -2.0, 5.1], [3.0, -1.0, 5.3]], np.float32)
    exact = corners.astype(np.float64)
    # From the side that shines, and not so flat that the turned area is itself a difference.
    normal = np.cross(exact[1] - exact[0], exact[2] - exact[0])
    area = 0.5 * np.linalg.norm(normal)
    normal /= 2.0 * area
    lean = np.random.default_rng(3).uniform(-1.0, 1.0, (COUNT, 3))
    start = (exact.mean(axis=0) + distance * (normal + 0.5 * lean)).astype(np.float32)
    d, pdf = testing.light_directions(scene_with_light("triangle"), 0, start, numbers(4))
    from_plane = (exact[0] - start) @ normal
    towards = d.astype(np.float64)
    cosine = towards @ normal / np.linalg.norm(towards, axis=1)
    t = from_plane / cosine
    off = np.abs(pdf * area * np.abs(cosine) / t**2 - 1.0)
    # A direction's rounding moves the point that it meets: two ulp of it, over the cosine.
    bound = TOLERANCE + 4.0 * 2.0**-24 / np.abs(cosine)
    # What is near is drawn from a place that is rounded to the light's coordinates.
    bound += 8.0 * 2.0**-24 * np.abs(exact).max() / np.abs(from_plane)
    worst = int(np.argmax(off - bound))
    assert (off <= bound).all(), f"{distance:g}: {off[worst]:.3g} from {start[worst]}"
    if distance >= 1e4:
        angle = solid_angle(exact, start.astype(np.float64))
        whole = np.abs(pdf * angle - 1.0)
        spread = 4.0 / distance
        assert whole.max() <= TOLERANCE + spread, f"{distance:g}: {whole.max():.3g}"


def test_the_solid_angle_of_a_sphere_a_thousandth_larger_is_told_apart() -> None:
    """Negative control."""
    start = around(np.array([3.0, -2.0, 5.0]), 1e6, 1)
    _, pdf = testing.light_directions(scene_with_light("sphere"), 0, start, numbers(2))
    squared = ((start.astype(np.float64) - np.array([3.0, -2.0, 5.0])) ** 2).sum(axis=1)
    angle = 2.0 * np.pi * 1.001**2 / squared / 2.0
    assert (np.abs(pdf * angle - 1.0) > 100 * TOLERANCE).all()
