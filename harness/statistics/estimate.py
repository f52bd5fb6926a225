"""Estimates with a standard error: what intervals, tests and combinations are made of."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from harness.statistics.intervals import (
    Interval,
    as_vector,
    standard_error,
    student_quantile,
    student_tail,
)


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number, its standard error, and how well that error is known."""

    value: float
    error: float
    """standard error in the unit of the value; NaN where the data do not tell"""
    degrees: float
    """degrees of freedom of `error`"""
    n: int
    """independent values behind it"""

    def interval(self, level: float = 0.95) -> Interval:
        """Student's t interval (Student 1908)."""
        if self.error == 0.0 or not math.isfinite(self.value):
            return Interval(self.value, self.value, self.value, self.n)
        half = student_quantile(0.5 + 0.5 * level, self.degrees) * self.error
        return Interval(self.value, self.value - half, self.value + half, self.n)

    def ratio(self, level: float = 0.95) -> Interval:
        """The interval of exp(value), for an estimate of a logarithm."""
        log = self.interval(level)
        with np.errstate(over="ignore"):
            value, lower, upper = (float(np.exp(x)) for x in (log.value, log.lower, log.upper))
        return Interval(value, lower, upper, self.n)

    def p_value(self, slack: float = 0.0) -> float:
        """Chance of a value so far from 0, two-sided, where the true one is within +-slack."""
        excess = max(abs(self.value) - slack, 0.0)
        if self.error == 0.0 or math.isinf(excess):
            return 0.0 if excess > 0.0 else 1.0
        return min(2.0 * student_tail(excess / self.error, self.degrees), 1.0)


def exactly(value: float) -> Estimate:
    """A number that is known."""
    return Estimate(value, 0.0, math.inf, 0)


def combine(terms: Iterable[tuple[float, Estimate]]) -> Estimate:
    """Sum of factor * estimate over independent estimates, degrees by Welch and Satterthwaite.

    degrees = (sum v)^2 / sum (v^2 / degrees) with the squared standard errors v of the terms
    (Satterthwaite 1946, An Approximate Distribution of Estimates of Variance Components). `n` is
    the smallest of those that are not exact.
    """
    known = list(terms)
    value = sum(factor * term.value for factor, term in known)
    squares = [(factor * term.error) ** 2 for factor, term in known]
    total = sum(squares)
    counts = [term.n for _, term in known if term.n > 0]
    if math.isnan(total):
        return Estimate(value, math.nan, math.nan, min(counts, default=0))
    spread = sum(square**2 / term.degrees for square, (_, term) in zip(squares, known, strict=True))
    degrees = total**2 / spread if spread > 0.0 else math.inf
    return Estimate(value, math.sqrt(total), degrees, min(counts, default=0))


def mean_of(values: ArrayLike) -> Estimate:
    """Mean of independent values."""
    vector = as_vector(values)
    return Estimate(
        float(vector.mean()), standard_error(vector), float(vector.size - 1), int(vector.size)
    )


def log_of(estimate: Estimate) -> Estimate:
    """Logarithm of a positive estimate, to first order: its error is the relative one.

    The logarithm of 0 is minus infinity. Raises ValueError for a negative estimate.
    """
    if estimate.value < 0.0:
        raise ValueError(f"a logarithm needs a value that is not negative, got {estimate.value}")
    if estimate.value == 0.0:
        return Estimate(-math.inf, 0.0, estimate.degrees, estimate.n)
    return Estimate(
        math.log(estimate.value), estimate.error / estimate.value, estimate.degrees, estimate.n
    )


def product_of_means(first: ArrayLike, second: ArrayLike) -> Estimate:
    """Product of two independent positive means: the squared relative errors add up.

    First-order error propagation (Taylor 1997, An Introduction to Error Analysis, section 3.8).
    Raises ValueError if a mean is negative.
    """
    log = combine([(1.0, log_of(mean_of(first))), (1.0, log_of(mean_of(second)))])
    value = math.exp(log.value)
    return Estimate(value, value * log.error, log.degrees, log.n)


def log_ratio_of_means(top: ArrayLike, bottom: ArrayLike, *, paired: bool) -> Estimate:
    """Logarithm of mean(top) / mean(bottom) of two samples that are not negative.

    Independent samples: relative errors add up, degrees by Welch. Paired ones (the same seeds on
    both sides): the error is that of the differences x_k / mean(x) - y_k / mean(y), the ratio
    estimator's (Cochran 1977, Sampling Techniques, section 6.4). It holds as well where the pairs
    have nothing in common, and is 0 where they are equal. Two black samples have ratio 1. Raises
    ValueError for paired samples of different sizes or a single value.
    """
    x, y = as_vector(top), as_vector(bottom)
    if paired and x.size != y.size:
        raise ValueError(f"{x.size} values cannot be paired with {y.size}")
    if min(x.size, y.size) < 2:
        raise ValueError("the error of a ratio needs at least 2 values on each side")
    n = min(x.size, y.size)
    if x.mean() == 0.0 or y.mean() == 0.0:
        value = float(np.sign(x.mean()) - np.sign(y.mean())) or 0.0
        return Estimate(value * math.inf if value else 0.0, 0.0, float(n - 1), int(n))
    if not paired:
        return combine([(1.0, log_of(mean_of(x))), (-1.0, log_of(mean_of(y)))])
    value = math.log(x.mean()) - math.log(y.mean())
    error = standard_error(x / x.mean() - y / y.mean())
    return Estimate(value, error, float(n - 1), int(n))


def ratio_to_nonnegative(top: Estimate, bottom: Estimate, level: float = 0.95) -> Interval:
    """Interval of top / bottom, where the true bottom is known not to be negative.

    Fieller's theorem (Fieller 1954, Some Problems in Interval Estimation): all ratios q at which
    top - q bottom does not differ from 0. Its variance at the estimate decides the degrees of
    freedom. Where the bottom cannot be told from 0 the set is unbounded: it ends at infinity on the
    side that the top's sign says, on both sides if that is not known. `value` is infinite where the
    bottom's estimate is not positive.
    """
    n = min((count for count in (top.n, bottom.n) if count > 0), default=0)
    below = max(bottom.value, 0.0)
    value = top.value / below if below > 0.0 else math.copysign(math.inf, top.value)
    slope = value if math.isfinite(value) else 0.0
    difference = combine([(1.0, top), (-slope, bottom)])
    if bottom.error == 0.0 and (top.error == 0.0 or below == 0.0):
        return Interval(value, value, value, n)
    t = student_quantile(0.5 + 0.5 * level, difference.degrees)
    # The ratios q with b q^2 - 2 p q + a <= 0.
    a, b = top.value**2 - (t * top.error) ** 2, below**2 - (t * bottom.error) ** 2
    p = top.value * below
    root = math.sqrt(max(p**2 - a * b, 0.0))
    if b > 0.0:
        return Interval(value, (p - root) / b, (p + root) / b, n)
    if a <= 0.0:
        return Interval(value, -math.inf, math.inf, n)
    # The root next to 0, where the bottom is the largest that agrees with the data.
    end = a / (p + math.copysign(root, top.value))
    if top.value > 0.0:
        return Interval(value, end, math.inf, n)
    return Interval(value, -math.inf, end, n)
