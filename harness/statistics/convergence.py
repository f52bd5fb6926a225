"""Slope of the error against the number of samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from harness.statistics.intervals import Interval

LEAST_SHARE = 0.1
"""A point whose error, less the truth's noise, is under this share of the raw error is unusable."""


@dataclass(frozen=True, slots=True)
class Fit:
    """error = scale * spp^slope."""

    slope: Interval
    scale: float
    points: tuple[int, ...]
    """the sample counts that entered the fit"""
    dropped: tuple[int, ...]
    """those at which the truth's noise hides the error"""

    def at(self, spp: float) -> float:
        """The fitted error at `spp` samples a pixel."""
        return float(self.scale * spp**self.slope.value)


def fit_slope(errors: Mapping[int, NDArray[np.float64]], floor: float, level: float = 0.95) -> Fit:
    """Fit the error of independent images at several sample counts by a power law.

    errors: spp -> error of each image, the truth's noise `floor` already removed. Weighted least
    squares of log(mean error) on log(spp) with the weights K / CV^2, the inverse variance of the
    logarithm of a mean of K values, the squared coefficient of variation being pooled over all
    counts since that of a few images would make the weights noise. The interval is Student's t
    with the pooled degrees of freedom, sum (K - 1). Where the points scatter about the line by more
    than that (outliers of heavy-tailed pixels, or no power law at all), it is widened to their
    scatter (Birge 1932), with two degrees of freedom less than there are points.

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
    squares = sum(
        float(np.sum((errors[n] - means[n]) ** 2)) / (means[n] + floor) ** 2 for n in usable
    )
    degrees = int(np.sum(sizes - 1))
    pooled = squares / degrees if degrees > 0 and squares > 0.0 else 1.0
    weight = sizes * net**2 / (pooled * raw**2)
    share = weight / weight.sum()
    x, y = np.log(np.array(usable, dtype=np.float64)), np.log(net)
    centre_x, centre_y = float(share @ x), float(share @ y)
    spread = float(share @ (x - centre_x) ** 2)
    slope = float(share @ ((x - centre_x) * (y - centre_y))) / spread
    intercept = centre_y - slope * centre_x
    half = float("nan")
    if degrees > 0:
        error = 1.0 / np.sqrt(weight.sum() * spread)
        scatter = float(weight @ (y - intercept - slope * x) ** 2) / (len(usable) - 2)
        if scatter > 1.0:
            error *= np.sqrt(scatter)
            degrees = min(degrees, len(usable) - 2)
        half = float(stats.t.ppf(0.5 + 0.5 * level, degrees) * error)
    return Fit(
        Interval(slope, slope - half, slope + half, int(sizes.sum())),
        float(np.exp(intercept)),
        tuple(usable),
        tuple(n for n in counts if n not in usable),
    )
