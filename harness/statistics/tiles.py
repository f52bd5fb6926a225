"""Welch test of 8x8 tiles: finds local errors to which the image mean is blind.

Jung, Hanika and Dachsbacher 2020, Detecting Bias in Monte Carlo Renderers using Welch's t-test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from harness.statistics.metrics import Image, luminance

TILE = 8
"""Edge of a tile in pixels."""

FAMILY_LEVEL = 0.01
"""Probability that correct renderers see any tile rejected, over all tiles of all images."""

WELCH_COUNT = 16
"""Values on each side from which the estimated degrees of freedom hold so far in the tail.

At p = 1e-5 Welch's test of equal means rejects 0.8 to 1.8 times as often as stated with 16 and 16
values, depending on the ratio of the variances (0.9 at 2 to 1), but 4 times as often with 8 and 16,
56 times with 4 and 16 (simulated, 2e7 trials each). With fewer values min(K, R) - 1 degrees are
taken, which never rejects too often (Hsu 1938).
"""


def rounding_bound(spp: int) -> float:
    """Relative difference that float32 accumulation of `spp` samples may leave: spp * 2^-24.

    n additions in float32 lose at most n u with u = 2^-24 (Higham 2002, section 4.2). At least
    256 u = 2^-16, since truth and test may accumulate in passes of their own.
    """
    return max(spp, 256) * 2.0**-24


def tile_means(images: Image, tile: int = TILE) -> NDArray[np.float64]:
    """Mean luminance of the tiles: [K, h, w, 3] -> [K, ceil(h / tile), ceil(w / tile)].

    Tiles at the right and bottom edges may be smaller.
    """
    light = luminance(images)
    height, width = light.shape[1:]
    rows, columns = np.arange(0, height, tile), np.arange(0, width, tile)
    sums = np.add.reduceat(np.add.reduceat(light, rows, axis=1), columns, axis=2)
    heights = np.diff(np.append(rows, height))
    widths = np.diff(np.append(columns, width))
    return np.asarray(sums / np.outer(heights, widths))


def welch_degrees_of(share: NDArray[np.float64] | float, n_a: int, n_b: int) -> NDArray[np.float64]:
    """Degrees of freedom where `share` of the squared standard error comes from the first side.

    Welch-Satterthwaite from WELCH_COUNT values on each side, min(n_a, n_b) - 1 below.
    """
    fraction = np.asarray(share, dtype=np.float64)
    if min(n_a, n_b) < WELCH_COUNT:
        return np.full_like(fraction, min(n_a, n_b) - 1)
    return np.asarray(1.0 / (fraction**2 / (n_a - 1) + (1.0 - fraction) ** 2 / (n_b - 1)))


def welch_test(
    first: NDArray[np.float64], second: NDArray[np.float64], rounding: float = 2.0**-16
) -> NDArray[np.float64]:
    """Two-sided p-values of equal means along axis 0: [K, ...], [R, ...] -> [...].

    t = (|a - b| - rounding max(|a|, |b|)) / sqrt(s_a^2 / K + s_b^2 / R), not below 0, with the
    degrees of freedom of Welch 1947 (fewer below WELCH_COUNT values). Differences within float32
    rounding are thus no evidence; where neither side varies, p is 1 within the bound and 0 beyond
    it. NaN in the data gives p = 0. Raises ValueError for fewer than two values on a side.
    """
    if min(first.shape[0], second.shape[0]) < 2:
        raise ValueError(
            "Welch's test needs at least 2 values on each side, got "
            f"{first.shape[0]}, {second.shape[0]}"
        )
    return welch_from_moments(
        *((side.mean(axis=0), side.var(axis=0, ddof=1), side.shape[0]) for side in (first, second)),
        rounding,
    )


Moments = tuple[NDArray[np.float64], NDArray[np.float64], int]
"""Means and unbiased variances of equal shape, and the number of values behind each."""


def welch_from_moments(first: Moments, second: Moments, rounding: float) -> NDArray[np.float64]:
    """`welch_test` of samples of which only the moments are known."""
    (mean_a, variance_a, n_a), (mean_b, variance_b, n_b) = first, second
    error_a, error_b = variance_a / n_a, variance_b / n_b
    scale = np.maximum(np.abs(mean_a), np.abs(mean_b))
    excess = np.maximum(np.abs(mean_a - mean_b) - rounding * scale, 0.0)
    total = error_a + error_b
    # A variance that is nothing but rounding of equal values counts as none.
    certain = ~(total > (2.0**-48 * scale) ** 2)
    share = np.divide(error_a, total, out=np.full_like(total, 0.5), where=~certain)
    degrees = welch_degrees_of(share, n_a, n_b)
    t = np.divide(excess, np.sqrt(total), out=np.zeros_like(total), where=~certain)
    p = 2.0 * stats.t.sf(t, degrees)
    p = np.where(certain, np.where(excess > 0.0, 0.0, 1.0), p)
    broken = ~np.isfinite(mean_a) | ~np.isfinite(mean_b)
    return np.asarray(np.where(broken, 0.0, np.minimum(p, 1.0)))


def sidak_level(tests: int, level: float = FAMILY_LEVEL) -> float:
    """Level of each of `tests` tests at which the family errs with probability `level`.

    1 - (1 - level)^(1 / tests), Sidak 1967.
    """
    if tests < 1:
        raise ValueError(f"a family needs at least 1 test, got {tests}")
    return float(-np.expm1(np.log1p(-level) / tests))


@dataclass(frozen=True, slots=True)
class TileTest:
    """p-values of the tiles of one image and what the test could have seen."""

    p: NDArray[np.float64]
    """[rows, columns]"""
    difference: NDArray[np.float64]
    """[rows, columns], mean test minus mean truth"""
    truth: NDArray[np.float64]
    """[rows, columns], mean truth"""
    error: NDArray[np.float64]
    """[rows, columns], standard error of the difference"""
    seeds: int
    batches: int

    @property
    def smallest(self) -> tuple[float, int, int]:
        """The smallest p-value with the row and column of its tile."""
        index = int(np.argmin(self.p))
        row, column = np.unravel_index(index, self.p.shape)
        return float(self.p[row, column]), int(row), int(column)

    def detectable(self, level: float) -> float:
        """Relative error of the median tile that is rejected at `level` half of the time.

        Tiles with a black truth are left out; NaN if all of them are black.
        """
        lit = self.truth > 0.0
        if not lit.any():
            return float("nan")
        degrees = float(welch_degrees_of(0.5, self.seeds, self.batches))
        critical = stats.t.isf(0.5 * level, degrees)
        return float(np.median(critical * self.error[lit] / self.truth[lit]))


def compare_tiles(
    images: Image, batches: Image, rounding: float = 2.0**-16, tile: int = TILE
) -> TileTest:
    """Welch test of each tile of images [K, h, w, 3] against truth batches [R, h, w, 3]."""
    first, second = tile_means(images, tile), tile_means(batches, tile)
    error = np.sqrt(
        first.var(axis=0, ddof=1) / first.shape[0] + second.var(axis=0, ddof=1) / second.shape[0]
    )
    truth = second.mean(axis=0)
    return TileTest(
        welch_test(first, second, rounding),
        first.mean(axis=0) - truth,
        truth,
        error,
        first.shape[0],
        second.shape[0],
    )
