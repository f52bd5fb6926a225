"""The law of a launch: its time over its number of rays, T = T0 + N / R.

Hockney's two parameters (R. W. Hockney, The Science of Computer Benchmarking, SIAM 1996, section
1.3): R is the rate of an infinitely long launch, T0 what an empty one takes, and T0 R the length at
which half of the rate is reached.

A render of L launches with N rays in all takes L T0 + N / R, whatever the sizes of the single
launches: the mean launch of a render is a point of the law, and none has to be timed by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from harness.statistics.intervals import Interval, student_quantile

LEAST_POINTS = 5
"""Two parameters, a kink with two, and something left that scatters."""
SIGNIFICANT = 0.01
"""A kink is reported where its p-value is smaller."""
DRAWS = 1000
"""Of the null distribution of the best kink."""
SEED = 20_110_401

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Kink:
    """Two lines that meet explain the times better than one."""

    rays: float
    """N at which they meet"""
    p_value: float
    """chance of so good a kink anywhere, where there is none"""
    slope_before: float
    """seconds a ray, may be 0 where small launches all take as long"""
    slope_after: float

    @property
    def significant(self) -> bool:
        """Whether one line is not enough."""
        return self.p_value < SIGNIFICANT


@dataclass(frozen=True, slots=True)
class LaunchLaw:
    """A fitted law, with what it leaves unexplained."""

    launch_seconds: Interval
    r_inf: Interval
    """rays a second"""
    n_half: Interval
    """rays; NaN bounds where nothing can be said"""
    points: int
    residuals: tuple[float, ...]
    """(T - fit) / fit of each point, in rising order of N"""
    scatter: float
    """their standard deviation, two degrees of freedom less than points"""
    runs_p_value: float
    """chance of so few changes of the residuals' sign, where they are independent"""
    kink: Kink

    def seconds(self, rays: float) -> float:
        """Time of a launch of so many rays."""
        return self.launch_seconds.value + rays / self.r_inf.value

    def share(self, rays: float) -> float:
        """Of R that a launch of so many rays reaches."""
        return rays / self.r_inf.value / self.seconds(rays)


def fit_launch_law(
    rays: Sequence[float], seconds: Sequence[Sequence[float]], level: float = 0.95
) -> LaunchLaw:
    """Fit T = T0 + N / R to launches of different sizes.

    Weighted least squares on the medians over repeats, each with the weight 1 / T^2: times from
    microseconds to seconds scatter in proportion to themselves. The weights are those of the fitted
    times, found by iteration (iteratively reweighted least squares: McCullagh and Nelder,
    Generalized Linear Models, 1989, section 2.5; a constant coefficient of variation with the
    identity as link). Intervals are Student's t with two degrees of freedom less than points, from
    the points' own scatter about the line, so that a law that does not hold has wide ones. That of
    N_1/2, a ratio of two estimates, is Fieller's (1954).

    Whether the law holds is asked twice. The signs of the residuals, in the order of N, must not
    come in fewer runs than chance has them (Wald and Wolfowitz 1940, exact). And two lines that
    meet at one of the inner points must not fit better: the F statistic of the best place, against
    its distribution over normal errors, drawn DRAWS times, because the place is chosen after
    looking (Andrews 1993).

    Parameters
    ----------
    rays
        N of each point, different numbers.
    seconds
        T of each point, one or more repeats.
    level
        Confidence level of the intervals.

    Raises
    ------
    ValueError
        There are too few points, or a number is not positive.
    """
    order = np.argsort(np.asarray(rays, dtype=np.float64))
    n = np.asarray(rays, dtype=np.float64)[order]
    most = float(n[-1])
    times = [np.asarray(seconds[i], dtype=np.float64) for i in order]
    if len(set(n)) < LEAST_POINTS:
        raise ValueError(f"a law needs at least {LEAST_POINTS} sizes of launches, got {len(n)}")
    if n[0] <= 0.0 or any(repeats.size == 0 or repeats.min() <= 0.0 for repeats in times):
        raise ValueError("rays and seconds of launches must be positive")
    t = np.array([float(np.median(repeats)) for repeats in times])
    # In units of the largest launch, so that the normal equations are well conditioned.
    terms = np.stack([np.ones(n.size), n / n[-1]], axis=1)
    scale = t.copy()
    for _ in range(50):
        coefficients, *_ = np.linalg.lstsq(terms / scale[:, None], t / scale, rcond=None)
        fitted = terms @ coefficients
        # A line that is not positive everywhere cannot weight its own points.
        fitted = np.where(fitted > 0.1 * t, fitted, 0.1 * t)
        done = np.allclose(fitted, scale, rtol=1e-10, atol=0.0)
        scale = fitted
        if done:
            break
    weighted = terms / scale[:, None]
    line = terms @ coefficients
    residuals = (t - line) / scale
    degrees = n.size - 2
    scatter = float(np.sqrt(residuals @ residuals / degrees))
    covariance = scatter**2 * np.linalg.inv(weighted.T @ weighted)
    student = student_quantile(0.5 + 0.5 * level, degrees)
    empty, slope = (float(value) for value in coefficients)
    half = student * np.sqrt(np.diag(covariance))
    return LaunchLaw(
        Interval(empty, empty - float(half[0]), empty + float(half[0]), n.size),
        _rate(slope / most, float(half[1]) / most, n.size),
        _scaled_ratio(coefficients, covariance, student, most, n.size),
        n.size,
        tuple(float(value) for value in residuals),
        scatter,
        runs_p_value(residuals),
        _best_kink(n, t, scale),
    )


def _rate(slope: float, half: float, points: int) -> Interval:
    """R = 1 / slope; without an upper end where the slope may be 0."""
    upper = 1.0 / (slope - half) if slope > half else float("inf")
    value = 1.0 / slope if slope > 0.0 else float("inf")
    return Interval(value, 1.0 / (slope + half) if slope + half > 0.0 else 0.0, upper, points)


def _scaled_ratio(
    estimate: Vector, covariance: Vector, student: float, scale: float, points: int
) -> Interval:
    """Fieller's interval of estimate[0] / estimate[1], times `scale`.

    E. C. Fieller, Some problems in interval estimation, J. R. Stat. Soc. B 16, 1954: all ratios r
    at which estimate[0] - r estimate[1] does not differ from 0. Not bounded, NaN here, where the
    denominator does not differ from 0.
    """
    a, b = float(estimate[0]), float(estimate[1])
    (v_a, v_ab), (_, v_b) = (student**2 * covariance).tolist()
    leading = b * b - v_b
    if leading <= 0.0:
        return Interval(scale * a / b, float("nan"), float("nan"), points)
    middle = (a * b - v_ab) / leading
    root = float(np.sqrt(max(middle**2 - (a * a - v_a) / leading, 0.0)))
    return Interval(scale * a / b, scale * (middle - root), scale * (middle + root), points)


@cache
def _ways(parts: int, of: int) -> float:
    """Ways to choose so many of a number of things."""
    return float(stats.binom.pmf(parts, of, 0.5) * 2.0**of) if parts <= of else 0.0


def runs_p_value(residuals: Vector) -> float:
    """Chance of so few runs of one sign or fewer, given how many there are of each.

    A. Wald and J. Wolfowitz, On a test whether two samples are from the same population, Annals of
    Mathematical Statistics 11, 1940, exact.
    """
    signs = residuals > 0.0
    above, below = int(signs.sum()), int((~signs).sum())
    runs = 1 + int((signs[1:] != signs[:-1]).sum())
    if above == 0 or below == 0:
        return 1.0

    total = 0.0
    for count in range(2, runs + 1):
        k = count // 2
        if count % 2 == 0:
            total += 2.0 * _ways(k - 1, above - 1) * _ways(k - 1, below - 1)
        else:
            total += _ways(k, above - 1) * _ways(k - 1, below - 1)
            total += _ways(k - 1, above - 1) * _ways(k, below - 1)
    return min(1.0, total / _ways(above, above + below))


def _best_kink(n: Vector, t: Vector, scale: Vector) -> Kink:
    """Of two lines that meet at an inner point, those that fit best."""
    line = np.stack([np.ones(n.size), n / n[-1]], axis=1) / scale[:, None]
    places = range(1, n.size - 1)
    bases = [
        np.column_stack([line, np.maximum(n - n[place], 0.0) / n[-1] / scale]) for place in places
    ]
    plain = np.linalg.qr(line)[0]
    bent = [np.linalg.qr(basis)[0] for basis in bases]

    def statistics(y: Vector) -> Vector:
        """F of each place, for each column of y."""
        left = np.sum(y**2, axis=0) - np.sum((plain.T @ y) ** 2, axis=0)
        least = np.stack([np.sum(y**2, axis=0) - np.sum((q.T @ y) ** 2, axis=0) for q in bent])
        least = np.maximum(least, 1e-12 * np.maximum(left, 1e-300))
        return np.asarray((left - least) / (least / (n.size - 3)))

    found = statistics((t / scale)[:, None])[:, 0]
    noise = np.random.default_rng(SEED).standard_normal((n.size, DRAWS))
    null = statistics(noise).max(axis=0)
    best = int(np.argmax(found))
    p_value = float((1 + np.count_nonzero(null >= found[best])) / (1 + DRAWS))
    coefficients, *_ = np.linalg.lstsq(bases[best], t / scale, rcond=None)
    before, bend = (float(value) / float(n[-1]) for value in coefficients[1:])
    return Kink(float(n[places[best]]), p_value, before, before + bend)
