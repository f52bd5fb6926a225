"""The film's integers."""

from __future__ import annotations

import numpy as np
import pytest
from core_meshes import CAMERA, mesh_scene
from haste_cuda._core import testing

import haste_cuda

FITS, NON_FINITE, OUT_OF_RANGE = 0, 1, 2


def test_values_above_the_unit_are_converted_exactly() -> None:
    random = np.random.default_rng(1)
    exponent = -40
    # 24 bits of mantissa lie above the unit from 2^-16 on; the range ends at 2^11.
    values = (random.random(10_000) * 2.0 ** random.uniform(-15, 10, 10_000)).astype(np.float32)
    values = np.maximum(values, np.float32(2.0**-16))
    units, status = testing.convert(values, exponent, 0x12345678)
    wrong = np.flatnonzero((units * 2.0**exponent != values.astype(np.float64)) | (status != FITS))
    assert wrong.size == 0, f"{values[wrong[:5]]} -> {units[wrong[:5]]}, status {status[wrong[:5]]}"


def test_a_value_below_the_unit_is_rounded_up_as_often_as_its_fraction_says() -> None:
    value, exponent = np.float32(0.3) * np.float32(2.0**-20), -20
    roundings = np.random.default_rng(2).integers(0, 1 << 32, 4000)
    ups = np.array([testing.convert(np.array([value]), exponent, int(r))[0][0] for r in roundings])
    error = np.sqrt(0.3 * 0.7 / len(ups))
    assert set(ups) == {0, 1} and abs(ups.mean() - 0.3) < 4 * error, f"mean {ups.mean()}"


def test_stochastic_rounding_keeps_the_expectation_to_the_last_of_its_bits() -> None:
    # The integer is floor(x + r 2^-32): up exactly for the r from 2^32 (1 - fraction) on.
    exponent, value = 0, np.float32(5.25)
    threshold = (1 << 32) - (1 << 30)
    below = testing.convert(np.array([value]), exponent, threshold - 1)[0][0]
    at = testing.convert(np.array([value]), exponent, threshold)[0][0]
    assert (below, at) == (5, 6)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0.0, FITS),
        (-0.0, FITS),
        (1e-45, FITS),
        (np.nan, NON_FINITE),
        (np.inf, NON_FINITE),
        (-np.inf, NON_FINITE),
        (-1.0, OUT_OF_RANGE),
        (2.0**11, OUT_OF_RANGE),
        (np.nextafter(np.float32(2.0**11), np.float32(0)), FITS),
        (3e38, OUT_OF_RANGE),
    ],
)
def test_what_does_not_fit_the_film_is_told_apart(value: float, expected: int) -> None:
    status = testing.convert(np.array([value], np.float32), -40, 0)[1][0]
    assert status == expected, f"{value!r}: status {status}"


def lit_scene(radiance: float, ambient_reflectance: float) -> haste_cuda.Scene:
    """One emitting square that fills the picture."""
    return haste_cuda.Scene(
        vertices=np.array([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], np.float32),
        normals=np.zeros((4, 3), np.float32),
        triangles=np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
        triangle_shape=np.zeros(2, np.uint32),
        spheres=np.zeros((0, 4), np.float32),
        sphere_shape=np.zeros(0, np.uint32),
        shapes=[haste_cuda.Shape(kind="mesh", material=0, light=0, first=0, count=2)],
        materials=[haste_cuda.Material(ambient=(ambient_reflectance,) * 3)],
        lights=[(0, (radiance,) * 3)],
        camera=CAMERA,
    )


@pytest.mark.parametrize("engine", ["depth_first", "packets"])
def test_a_contribution_beyond_the_range_is_refused_with_its_pixel(engine: str) -> None:
    # The whitted ambient term is k_a times a constant: k_a = 4000 leaves the head-room of 2^10.
    settings = haste_cuda.Settings(max_layers=1, ambient=(1, 1, 1))
    with pytest.raises(haste_cuda.FilmOverflow, match=r"pixel \(0, 0\)"):
        haste_cuda.render_cpu(
            lit_scene(1, 4000), "whitted", settings, seed=1, samples=2, engine=engine
        )


@pytest.mark.parametrize("engine", ["depth_first", "packets"])
def test_contributions_that_are_not_finite_are_dropped_and_counted(engine: str) -> None:
    settings = haste_cuda.Settings(max_layers=1, ambient=(1, 1, 1))
    answer = haste_cuda.render_cpu(
        lit_scene(1, np.nan), "whitted", settings, seed=1, samples=2, engine=engine
    )
    assert answer["non_finite"] == 20 * 20 * 2
    assert np.array_equal(answer["film"], np.ones((20, 20, 3)))


def test_a_render_in_many_passes_is_the_render_in_one() -> None:
    settings = haste_cuda.Settings(max_depth=3)
    one = haste_cuda.render_cpu(lit_scene(2.5, 0), "path", settings, seed=1, samples=12)
    many = haste_cuda.render_cpu(
        lit_scene(2.5, 0), "path", settings, seed=1, samples=12, pass_samples=5
    )
    assert np.array_equal(one["film"], many["film"]) and one["film"].mean() == 2.5


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"samples": 0}, "samples"),
        ({"packet": 0, "engine": "packets"}, "packet"),
        ({"threads": -1}, "threads"),
        ({"pass_samples": 5000}, "pass_samples"),
        ({"engine": "wavefront"}, "engine"),
        ({"order": "random"}, "order"),
        ({"intersector": "embree", "engine": "packets"}, "embree"),
    ],
)
def test_a_schedule_that_makes_no_sense_is_refused_by_name(
    changes: dict[str, object], name: str
) -> None:
    scene = mesh_scene(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32))
    arguments = {"seed": 1, "samples": 1, **changes}
    with pytest.raises(ValueError, match=name):
        haste_cuda.render_cpu(scene, "path", haste_cuda.Settings(), **arguments)


@pytest.mark.parametrize(
    ("model", "changes"),
    [
        ("path", {"max_depth": 0}),
        ("path", {"clamp": 0.0}),
        ("path", {"clamp": np.nan}),
        ("haste", {"max_layers": 0}),
        ("haste", {"light_samples": 0}),
        ("haste", {"ambient_samples": 0}),
    ],
)
def test_settings_that_make_no_sense_are_refused_by_name(
    model: str, changes: dict[str, object]
) -> None:
    scene = mesh_scene(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32))
    with pytest.raises(ValueError, match=next(iter(changes))):
        haste_cuda.render_cpu(scene, model, haste_cuda.Settings(**changes), seed=1, samples=1)


def test_a_ray_of_the_queue_takes_64_bytes() -> None:
    assert testing.ray_bytes == 64
