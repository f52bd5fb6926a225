"""The Phong lobe keeps its digits up to an exponent of a million, in value and in samples."""

from __future__ import annotations

import numpy as np
import pytest
from haste_cuda._core import testing
from numpy.typing import NDArray
from scipy import stats

import haste_cuda

EXPONENTS = [10.0**power for power in range(7)]
SAMPLES = 200_000
VIEW = (0.0, 0.6, 0.8)
Floats = NDArray[np.float64]


def lobe(exponent: float) -> haste_cuda.Material:
    return haste_cuda.Material(specular=(1.0, 1.0, 1.0), exponent=exponent)


def near_mirror(exponent: float, seed: int) -> tuple[NDArray[np.float32], Floats]:
    """Directions inside the lobe, and the exact lobe there: (n + 2) / 2 pi cos^n times cosine."""
    random = np.random.default_rng(seed)
    mirror = np.array([-VIEW[0], -VIEW[1], VIEW[2]], np.float32).astype(np.float64)
    # cos^n falls to a thousandth at an angle of about sqrt(14 / n).
    spread = min(1.0, np.sqrt(14.0 / exponent)) * random.random((20_000, 1))
    aside = random.normal(size=(20_000, 3))
    aside -= (aside @ mirror)[:, None] * mirror
    w = mirror + spread * aside / np.linalg.norm(aside, axis=1, keepdims=True)
    w = (w / np.linalg.norm(w, axis=1, keepdims=True)).astype(np.float32)
    exact = w.astype(np.float64)
    one_minus_cosine = 0.5 * ((exact - mirror) ** 2).sum(axis=1)
    power = np.exp(exponent * np.log1p(-one_minus_cosine))
    return w, (exponent + 2.0) / (2.0 * np.pi) * power * exact[:, 2]


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_the_value_of_the_lobe_is_right_to_two_millionths(exponent: float) -> None:
    w, exact = near_mirror(exponent, 5)
    up = exact > 1e-3 * exact.max()
    value = testing.bsdf_evaluate(lobe(exponent), VIEW, w)[0][:, 0].astype(np.float64)
    off = np.abs(value[up] - exact[up]) / exact[up]
    # Of a value that has fallen to e^-x, the roundings of |R - w|^2 and of the logarithm are
    # magnified x times: five of half an ulp, at x <= 7, and those of the product itself.
    bound = 2e-6 + 5.0 * 2.0**-24 * np.log(exact.max() / exact[up])
    worst = int(np.argmax(off - bound))
    assert (off <= bound).all(), f"exponent {exponent:g}: {off[worst]:.3g} at {w[up][worst]}"
    peak = exact[up] > 0.5 * exact.max()
    assert off[peak].max() <= 2e-6, f"exponent {exponent:g}: {off[peak].max():.3g} at the peak"


def test_samples_follow_the_lobe_at_every_exponent() -> None:
    """Chi-square of height and azimuth, judged together: Sidak's level for seven tests."""
    level = 1.0 - 0.99 ** (1.0 / len(EXPONENTS))
    for exponent in EXPONENTS:
        numbers = np.random.default_rng(int(exponent)).random((SAMPLES, 3)).astype(np.float32)
        w = testing.warp("phong", numbers, exponent).astype(np.float64)
        squared = (w[:, :2] ** 2).sum(axis=1)
        # cos^(n + 1) is uniform; from the sine, whose digits a sharp lobe keeps.
        height = np.exp(0.5 * (exponent + 1.0) * np.log1p(-np.minimum(squared, 1.0 - 1e-15)))
        turn = np.arctan2(w[:, 1], w[:, 0]) / (2.0 * np.pi) + 0.5
        counts, _, _ = np.histogram2d(height, turn, bins=(32, 16), range=((0, 1), (0, 1)))
        p = stats.chisquare(counts.ravel()).pvalue
        assert p > level, f"exponent {exponent:g}: p = {p:.2g}"


def test_a_lobe_of_a_tenth_more_is_told_apart() -> None:
    """Negative control."""
    numbers = np.random.default_rng(1).random((SAMPLES, 3)).astype(np.float32)
    w = testing.warp("phong", numbers, 1.1e6).astype(np.float64)
    height = np.exp(0.5 * (1e6 + 1.0) * np.log1p(-(w[:, :2] ** 2).sum(axis=1)))
    counts, _ = np.histogram(height, bins=32, range=(0, 1))
    assert stats.chisquare(counts).pvalue < 1e-9
