"""Times, throughput and efficiency.

A renderer that needs T seconds for an image of variance V reaches variance v in T V / v seconds.
T V is therefore its time to unit variance (TTUV), and 1 / (T V) its efficiency (Pharr, Jakob and
Humphreys, Physically Based Rendering, section 2.2).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harness.statistics.estimate import Estimate, log_of, product_of_means
from harness.statistics.intervals import (
    Interval,
    as_vector,
    log_ratio_interval,
    median_interval,
)


def throughput(work: float, seconds: ArrayLike, level: float = 0.95) -> Interval:
    """Median of work / seconds over repeats, in units of work a second.

    Raises ValueError if a time is not positive.
    """
    times = as_vector(seconds)
    if times.min() <= 0.0:
        raise ValueError(f"a time must be positive, got {times.min()} s")
    return median_interval(work / times, level)


def speed_ratio(
    seconds: ArrayLike,
    spp: int,
    other_seconds: ArrayLike,
    other_spp: int,
    level: float = 0.95,
) -> Interval:
    """How many times more samples a second than the other, with its interval.

    Ratio of geometric means over repeats; the two may have used different sample counts.
    """
    return log_ratio_interval(as_vector(other_seconds) / other_spp, as_vector(seconds) / spp, level)


def time_to_unit_variance(
    variance_by_image: ArrayLike, image_spp: int, seconds: ArrayLike, timed_spp: int
) -> Estimate:
    """TTUV = Var T in seconds times squared radiance (seconds for a relative variance).

    The variance of an image falls, and its time grows, in proportion to its samples, so that both
    are taken per sample: images of `image_spp` may be combined with times at `timed_spp`. Raises
    ValueError for a negative mean.
    """
    per_sample = as_vector(variance_by_image) * image_spp
    return product_of_means(per_sample, as_vector(seconds) / timed_spp)


def positive_interval(estimate: Estimate, level: float = 0.95) -> Interval:
    """Interval of a positive quantity, symmetric in the logarithm; no width at 0."""
    return log_of(estimate).ratio(level)


def efficiency(ttuv: Interval) -> Interval:
    """1 / TTUV; the bounds change places."""
    with np.errstate(divide="ignore"):
        value, lower, upper = (
            float(np.divide(1.0, x)) for x in (ttuv.value, ttuv.upper, ttuv.lower)
        )
    return Interval(value, lower, upper, ttuv.n)
