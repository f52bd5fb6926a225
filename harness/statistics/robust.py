"""How errors spread over runs and pixels: pictures beside the means, never in their place."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from harness.statistics.intervals import Interval, as_vector
from harness.statistics.metrics import Image, luminance


def quantile_interval(values: ArrayLike, quantile: float, level: float = 0.95) -> Interval:
    """A quantile of independent values, with its distribution-free interval.

    Conover, Practical Nonparametric Statistics, section 3.2: the order statistics r and s with
    P(B < r) <= (1 - level) / 2 and P(B >= s) <= (1 - level) / 2 for B binomial of n values and the
    quantile. An end that n values do not reach is infinite. Raises ValueError for a quantile
    outside of (0, 1).
    """
    if not 0.0 < quantile < 1.0:
        raise ValueError(f"a quantile lies between 0 and 1, got {quantile}")
    vector = np.sort(as_vector(values))
    n, tail = vector.size, 0.5 * (1.0 - level)
    # binom.ppf is the least count whose distribution function reaches the tail.
    below = int(stats.binom.ppf(tail, n, quantile))
    above = int(stats.binom.isf(tail, n, quantile)) + 1
    lower = float(vector[below - 1]) if below > 0 else -np.inf
    upper = float(vector[above - 1]) if above <= n else np.inf
    return Interval(float(np.quantile(vector, quantile)), lower, upper, int(n))


def effective_pixels(images: Image) -> float:
    """Number of pixels that carry the variance of images [K, h, w, 3]: (sum s^2)^2 / sum s^4.

    Kish 1965, Survey Sampling, section 8.2, the effective size of a weighted sample. The squared
    error of one image spreads by about sqrt(2 / P) of itself. NaN where nothing varies. Raises
    ValueError for fewer than two images.
    """
    if images.shape[0] < 2:
        raise ValueError("the variance of a pixel needs at least 2 images")
    variance = luminance(images).var(axis=0, ddof=1)
    square = float(np.sum(variance**2))
    return float(np.sum(variance)) ** 2 / square if square > 0.0 else float("nan")
