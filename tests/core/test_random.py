"""Philox and the warps."""

from __future__ import annotations

import numpy as np
import pytest
from haste_cuda._core import testing
from scipy import stats

KNOWN_ANSWERS = [
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]
"""Random123's kat_vectors for philox4x32, 10 rounds."""

EDGE = np.array([0.0, 2.0**-24, 0.25, 0.5, 1 - 2.0**-24], np.float32)


@pytest.mark.parametrize(("counter", "key", "expected"), KNOWN_ANSWERS)
def test_philox_gives_the_known_answers(
    counter: tuple[int, ...], key: tuple[int, ...], expected: tuple[int, ...]
) -> None:
    assert testing.philox(counter, key) == expected, f"counter {counter}, key {key}"


def test_sine_and_cosine_of_a_turn_are_within_two_roundings_of_one() -> None:
    turns = np.concatenate([EDGE, np.random.default_rng(3).random(200_000, np.float32)])
    turns = np.minimum(turns, np.float32(1 - 2.0**-24))
    angle = 2 * np.pi * turns.astype(np.float64)
    error = np.abs(testing.sin_cos_of_turn(turns) - np.stack([np.sin(angle), np.cos(angle)], -1))
    worst = np.unravel_index(error.argmax(), error.shape)
    # Two roundings at magnitude 1, and that of 2 pi times an eighth of a turn.
    assert error.max() <= 4 * 2.0**-24, f"turn {turns[worst[0]]!r}: error {error.max():.3g}"


def numbers(count: int, seed: int) -> np.ndarray:
    """Uniform numbers on the generator's lattice, edges of the unit cube included."""
    random = np.random.default_rng(seed).integers(0, 1 << 24, (count, 3)) * 2.0**-24
    edges = np.stack(np.meshgrid(EDGE, EDGE, EDGE), -1).reshape(-1, 3)
    return np.vstack([edges, random]).astype(np.float32)


@pytest.mark.parametrize(
    ("name", "parameter"),
    [
        ("sphere", 0),
        ("hemisphere", 0),
        ("cosine", 0),
        ("cone", 1e-6),
        ("cone", 0.7),
        ("phong", 1),
        ("phong", 1e4),
    ],
)
def test_directions_have_unit_length_also_at_the_edges_of_the_unit_cube(
    name: str, parameter: float
) -> None:
    points = testing.warp(name, numbers(100_000, 5), parameter).astype(np.float64)
    error = np.abs(np.linalg.norm(points, axis=1) - 1)
    worst = error.argmax()
    # |d|^2 = r^2 + z^2 of a handful of rounded factors.
    assert np.isfinite(points).all() and error.max() <= 8 * 2.0**-24, (
        f"{name}({parameter}): {numbers(100_000, 5)[worst]} -> {points[worst]}"
    )


# The cosine of the polar angle has this cumulative distribution, given the parameter.
POLAR = {
    "sphere": (0, lambda z, _: (1 + z) / 2),
    "hemisphere": (0, lambda z, _: z),
    "cosine": (0, lambda z, _: z**2),
    "cone": (0.3, lambda z, c: 1 - (1 - z) / c),
    "phong": (30.0, lambda z, n: z ** (n + 1)),
}


@pytest.mark.parametrize("name", POLAR)
def test_a_warp_has_its_stated_distribution(name: str) -> None:
    parameter, distribution = POLAR[name]
    u = np.random.default_rng(7).random((100_000, 3), np.float32)
    points = testing.warp(name, u, parameter).astype(np.float64)
    polar = stats.kstest(np.clip(points[:, 2], -1, 1), lambda z: distribution(z, parameter)).pvalue
    azimuth = np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi) % 1
    around = stats.kstest(azimuth, "uniform").pvalue
    assert min(polar, around) > 1e-3, f"{name}({parameter}): p = {polar:.2g}, {around:.2g}"


def test_a_wrong_distribution_is_rejected_by_the_same_test() -> None:
    u = np.random.default_rng(7).random((100_000, 3), np.float32)
    z = testing.warp("cosine", u)[:, 2].astype(np.float64)
    assert stats.kstest(z, lambda z: z).pvalue < 1e-12


def test_points_of_the_ball_fill_its_volume_evenly() -> None:
    u = np.random.default_rng(9).random((100_000, 3), np.float32)
    radius = np.linalg.norm(testing.warp("ball", u).astype(np.float64), axis=1)
    assert stats.kstest(np.clip(radius, 0, 1) ** 3, "uniform").pvalue > 1e-3


def test_points_of_a_triangle_are_uniform_by_area() -> None:
    u = np.random.default_rng(11).random((100_000, 3), np.float32)
    b = testing.warp("triangle", u).astype(np.float64)
    assert b.min() >= -(2.0**-24)
    # Each barycentric coordinate of a uniform point has the density 2 (1 - b).
    p = [stats.kstest(b[:, k], lambda x: 1 - (1 - x) ** 2).pvalue for k in range(3)]
    assert min(p) > 1e-3, f"p = {p}"
