"""What speed costs in accuracy: error at a time, time to an error, where a shortcut stops paying.

An image of T seconds has the expected squared error MSE(T) = Bias^2 + TTUV / T: the bias stays, the
variance falls with the time. TTUV is the time to unit variance of `harness.statistics.timing`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.statistics.estimate import Estimate, combine, exactly, log_of, ratio_to_nonnegative
from harness.statistics.intervals import Interval
from harness.statistics.metrics import Image, Split, Truth


def bias_squared_of(split: Split) -> Estimate:
    """The squared bias of a split error as an estimate; its error is the jackknife's."""
    count = int(split.variance_by_image.size)
    return Estimate(split.bias_squared, split.bias_squared_error, float(count - 1), count)


def error_at(seconds: float, bias_squared: Estimate, ttuv: Estimate) -> Estimate:
    """MSE(T) = Bias^2 + TTUV / T.

    The split of a squared error (Geman, Bienenstock and Doursat 1992) with the variance of T
    seconds of independent samples (Pharr, Jakob and Humphreys, Physically Based Rendering, section
    2.2.2). Raises ValueError unless the time is positive.
    """
    if seconds <= 0.0:
        raise ValueError(f"a time must be positive, got {seconds} s")
    return combine([(1.0, bias_squared), (1.0 / seconds, ttuv)])


def error_curve(
    seconds: NDArray[np.float64], bias_squared: Interval, ttuv: Interval
) -> NDArray[np.float64]:
    """`error_at` many times from two intervals: values, lower and upper bounds [3, N].

    The half-widths of the two parts are added as errors are, each on its own side. A bound that is
    not known adds nothing.
    """
    value = bias_squared.value + ttuv.value / seconds

    def reach(bias: float, unit: float) -> NDArray[np.float64]:
        return np.hypot(np.nan_to_num(bias), np.nan_to_num(unit) / seconds)

    below = reach(bias_squared.value - bias_squared.lower, ttuv.value - ttuv.lower)
    above = reach(bias_squared.upper - bias_squared.value, ttuv.upper - ttuv.value)
    return np.array([value, value - below, value + above])


def effort_to_error(
    target: float, bias_squared: Estimate, unit_variance: Estimate, level: float = 0.95
) -> Interval:
    """What brings the error down to `target`: unit_variance / (target - Bias^2).

    MSE(T) = target solved for T. With the time to unit variance it is seconds; with the variance of
    one sample a pixel it is samples a pixel. Infinite where the bias alone exceeds the target.
    """
    room = combine([(1.0, exactly(target)), (-1.0, bias_squared)])
    if room.value <= 0.0:
        lower = ratio_to_nonnegative(unit_variance, room, level).lower
        possible = room.interval(level).upper > 0.0
        return Interval(np.inf, max(lower, 0.0) if possible else np.inf, np.inf, unit_variance.n)
    found = ratio_to_nonnegative(unit_variance, room, level)
    return Interval(found.value, max(found.lower, 0.0), found.upper, unit_variance.n)


def crossover_seconds(
    exact_ttuv: Estimate, fast_ttuv: Estimate, fast_bias_squared: Estimate, level: float = 0.95
) -> Interval:
    """Time up to which a fast, biased variant has the smaller error than an exact one.

    T* = (TTUV_exact - TTUV_fast) / Bias^2_fast, from MSE_exact(T*) = MSE_fast(T*) with the MSE of
    `error_at`. Zero or less: the exact one is better at any time. The interval is Fieller's; it
    ends at infinity where the bias cannot be told from none.
    """
    gain = combine([(1.0, exact_ttuv), (-1.0, fast_ttuv)])
    return ratio_to_nonnegative(gain, fast_bias_squared, level)


def speed_up(ttuv: Estimate, other_ttuv: Estimate, level: float = 0.95) -> Interval:
    """How many times sooner than the other the same variance is reached: TTUV_other / TTUV.

    The interval is Student's of the log ratio, its variance the sum of the squared relative errors
    (first order), so that swapping the two inverts it. Raises ValueError unless both are positive.
    """
    if min(ttuv.value, other_ttuv.value) <= 0.0:
        raise ValueError(f"a speed-up needs positive times, got {ttuv.value}, {other_ttuv.value}")
    return combine([(1.0, log_of(other_ttuv)), (-1.0, log_of(ttuv))]).ratio(level)


def least_squares_scale(images: Image, truth: Truth) -> float:
    """The factor c that brings images [K, h, w, 3] closest to the truth: an exposure.

    c = sum w r x / sum w x^2 minimises sum w (c x - r)^2 with relMSE's weight w. The square of the
    mean image x is taken without its noise, x^2 - s_x^2 / K. 1 where the images are black. Raises
    ValueError for fewer than two images.
    """
    count = images.shape[0]
    if count < 2:
        raise ValueError("a scale needs at least 2 images")
    mean = images.mean(axis=0)
    square = mean**2 - images.var(axis=0, ddof=1) / count
    total = float(np.sum(truth.weight * square))
    return float(np.sum(truth.weight * truth.mean * mean)) / total if total > 0.0 else 1.0
