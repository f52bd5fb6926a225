"""Sums of many samples, and of bright and dark ones, keep their digits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import haste_cuda

Rgb = tuple[float, float, float]


def sky(environment: Rgb, bright: Rgb = (0.0, 0.0, 0.0)) -> Any:
    """One pixel that sees a uniform sky; behind the camera a sphere that may emit."""
    camera = haste_cuda.Camera(
        origin=(0, 0, 0),
        corner=(-0.5, 0.5, -1),
        dx=(1, 0, 0),
        dy=(0, -1, 0),
        near=0.01,
        width=1,
        height=1,
    )
    emits = any(bright)
    return haste_cuda.Scene(
        vertices=np.zeros((0, 3), np.float32),
        normals=np.zeros((0, 3), np.float32),
        triangles=np.zeros((0, 3), np.uint32),
        triangle_shape=np.zeros(0, np.uint32),
        spheres=np.array([(0, 0, 5, 1)], np.float32),
        sphere_shape=np.zeros(1, np.uint32),
        shapes=[
            haste_cuda.Shape(
                kind="sphere", material=0, first=0, count=1, **({"light": 0} if emits else {})
            )
        ],
        materials=[haste_cuda.Material(diffuse=(0.5, 0.5, 0.5))],
        lights=[(0, bright)] if emits else [],
        camera=camera,
        environment=environment,
    )


def mean(scene: Any, samples: int) -> np.ndarray:
    settings = haste_cuda.Settings(max_depth=1)
    done = haste_cuda.render_cpu(scene, "path", settings, seed=1, samples=samples, threads=2)
    assert done["non_finite"] == 0
    return done["film"][0, 0]


@pytest.mark.parametrize("samples", [1, 10**3, 10**6])
def test_the_mean_of_a_constant_is_the_constant_at_any_number_of_samples(samples: int) -> None:
    value = (0.7, 0.3, 0.11)
    exact = np.array(value, np.float32).astype(np.float64)
    off = np.abs(mean(sky(value), samples) - exact) / exact
    assert off.max() <= 1e-6, f"{samples} samples: {off}"


def test_a_dark_sky_keeps_its_digits_beside_a_light_of_a_hundred_million() -> None:
    """The film's unit comes from the brightest light: what is below it is rounded at random, by
    half a unit of 1.5e-4 hundredths at most, which averages out."""
    value = (1e-2, 2e-2, 3e-2)
    off = np.abs(mean(sky(value, (1e8, 1e8, 1e8)), 400_000) / np.array(value) - 1.0)
    assert off.max() <= 1e-4, off


def test_a_light_of_a_hundred_million_keeps_its_digits() -> None:
    value = (1e8, 1e8, 1e8)
    off = np.abs(mean(sky(value), 1000) / np.array(value, np.float32) - 1.0)
    assert off.max() <= 1e-4, off
