"""Slope of the error against the number of samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from harness.statistics.intervals import Interval, student_quantile, student_tail

LEAST_SHARE = 0.1
"""A point whose error, less the truth's noise, is under this share of the raw error is unusable."""


UNBIASED = -1.0
"""Slope of the squared error of unbiased Monte Carlo with independent samples."""


@dataclass(frozen=True, slots=True)
class Fit:
    """error = scale * spp^slope."""

    slope: Interval
    scale: float
    points: tuple[int, ...]
    """the sample counts that entered the fit"""
    dropped: tuple[int, ...]
    """those at which the truth's noise hides the error"""
    p_value: float
    """two-sided, of the slope being that of unbiased Monte Carlo; NaN where there is no interval"""

    def at(self, spp: float) -> float:
        """The fitted error at `spp` samples a pixel."""
        return float(self.scale * spp**self.slope.value)


def spread_of_errors(
    errors: Mapping[int, NDArray[np.float64]], floor: float
) -> Callable[[float], float]:
    """Squared coefficient of variation of an image's error as a function of its spp n: A + B / n.

    The error of a pixel that is the mean of n samples with variance s^2 and excess kurtosis g has
    the mean s^2 / n and the variance (s^2 / n)^2 (2 + g / n), from the fourth moment of a mean; the
    sum over pixels keeps the form. B is the share of rare bright samples, which a single number for
    all n would charge to the counts that do not have them. A and B >= 0 by least squares on the
    squared coefficients of variation at each n, twice, since their own spread goes with their size;
    1 for all n where the images of every count are equal.
    """
    counts = [n for n in sorted(errors) if errors[n].size > 1]
    degrees = np.array([errors[n].size - 1 for n in counts], dtype=np.float64)
    found = np.array(
        [np.var(errors[n], ddof=1) / (np.mean(errors[n]) + floor) ** 2 for n in counts]
    )
    if not counts or not found.any():
        return lambda _: 1.0
    terms = np.stack([np.ones(len(counts)), 1.0 / np.array(counts, dtype=np.float64)], axis=1)
    expected = np.full(len(counts), float(degrees @ found / degrees.sum()))
    constant, tail = 0.0, 0.0
    for _ in range(2):
        weight = np.sqrt(degrees) / expected
        (constant, tail), _ = optimize.nnls(terms * weight[:, None], found * weight)
        expected = np.maximum(terms @ np.array([constant, tail]), 1e-3 * found.max())
    return lambda n: max(constant + tail / n, 1e-3 * float(found.max()))


def fit_slope(errors: Mapping[int, NDArray[np.float64]], floor: float, level: float = 0.95) -> Fit:
    """Fit the error of independent images at several sample counts by a power law.

    errors: spp -> error of each image, the truth's noise `floor` already removed. Weighted least
    squares of log(mean error) on log(spp) with the weights K / CV^2, the inverse variance of the
    logarithm of a mean of K values. The squared coefficient of variation follows `spread_of_errors`
    over all counts, since that of a few images would make the weights noise. The interval is
    Student's t with the degrees of freedom of all images, sum (K - 1). Where the points scatter
    about the line by more than that (rare bright samples that a count's few images have missed, or
    no power law at all), it is widened to their scatter (Birge 1932), with two degrees of freedom
    less than there are points.

    Unbiased Monte Carlo has slope -1; bias, or a truth that is too noisy, flattens it. Raises
    ValueError if fewer than three usable points are left or all errors are zero.
    """
    counts = sorted(errors)
    means = {n: float(np.mean(errors[n])) for n in counts}
    usable = [n for n in counts if means[n] > LEAST_SHARE * (means[n] + floor)]
    if len(usable) < 3:
        raise ValueError(f"a slope needs at least 3 usable sample counts, got {usable} of {counts}")
    sizes = np.array([errors[n].size for n in usable])
    net = np.array([means[n] for n in usable])
    raw = net + floor
    degrees = int(np.sum(sizes - 1))
    spread = spread_of_errors({n: errors[n] for n in usable}, floor)
    weight = sizes * net**2 / (np.array([spread(n) for n in usable]) * raw**2)
    share = weight / weight.sum()
    x, y = np.log(np.array(usable, dtype=np.float64)), np.log(net)
    centre_x, centre_y = float(share @ x), float(share @ y)
    lever = float(share @ (x - centre_x) ** 2)
    slope = float(share @ ((x - centre_x) * (y - centre_y))) / lever
    intercept = centre_y - slope * centre_x
    half = p_value = float("nan")
    if degrees > 0:
        error = 1.0 / np.sqrt(weight.sum() * lever)
        scatter = float(weight @ (y - intercept - slope * x) ** 2) / (len(usable) - 2)
        if scatter > 1.0:
            error *= np.sqrt(scatter)
            degrees = min(degrees, len(usable) - 2)
        half = student_quantile(0.5 + 0.5 * level, degrees) * float(error)
        p_value = 2.0 * student_tail(abs(slope - UNBIASED) / float(error), degrees)
    return Fit(
        Interval(slope, slope - half, slope + half, int(sizes.sum())),
        float(np.exp(intercept)),
        tuple(usable),
        tuple(n for n in counts if n not in usable),
        p_value,
    )
