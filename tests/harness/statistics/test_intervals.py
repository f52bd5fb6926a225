"""Coverage of intervals, by simulation from a fixed seed.

A simulated coverage of n trials has standard deviation sqrt(0.95 * 0.05 / n): 0.007 at 1000. The
bounds below leave four of them.
"""

import numpy as np
import pytest
from scipy import stats

from harness.statistics import intervals, timing

TRIALS = 1000
SLACK = 4.0 * np.sqrt(0.95 * 0.05 / TRIALS)


def coverage(found: list[intervals.Interval], truth: float) -> float:
    return float(np.mean([interval.lower <= truth <= interval.upper for interval in found]))


@pytest.mark.parametrize("count", [4, 8, 16])
def test_the_t_interval_covers_a_skewed_mean(count: int):
    random = np.random.default_rng(count)
    found = [intervals.t_interval(random.gamma(8.0, size=count)) for _ in range(TRIALS)]
    assert coverage(found, 8.0) == pytest.approx(0.95, abs=SLACK + 0.01)


def test_the_t_interval_equals_the_textbook():
    interval = intervals.t_interval([1.0, 2.0, 3.0, 4.0])
    half = stats.t.ppf(0.975, 3) * np.std([1, 2, 3, 4], ddof=1) / 2.0
    assert (interval.lower, interval.upper) == pytest.approx((2.5 - half, 2.5 + half))


def test_the_ratio_interval_covers_and_inverts():
    random = np.random.default_rng(7)
    found = []
    for _ in range(TRIALS):
        top, bottom = random.lognormal(0.7, 0.05, 5), random.lognormal(0.0, 0.02, 5)
        found.append(intervals.log_ratio_interval(top, bottom))
    # Welch's approximation errs on the safe side at four degrees of freedom.
    assert 0.95 - SLACK <= coverage(found, np.exp(0.7)) <= 0.98
    swapped = intervals.log_ratio_interval(bottom, top)
    assert swapped.lower == pytest.approx(1.0 / found[-1].upper)


@pytest.mark.parametrize("count", [6, 9, 15, 40])
def test_the_median_interval_covers_at_least_its_level(count: int):
    random = np.random.default_rng(count)
    found = [intervals.median_interval(random.exponential(size=count)) for _ in range(TRIALS)]
    assert coverage(found, np.log(2.0)) >= 0.95 - SLACK


def test_the_median_interval_of_a_few_noisy_times_covers():
    random = np.random.default_rng(5)
    found = [intervals.median_interval(random.lognormal(0.0, 0.1, 5)) for _ in range(TRIALS)]
    # The median spreads 1.2 times as much as the mean at five values: about two points are lost.
    assert coverage(found, 1.0) >= 0.92


def test_time_to_unit_variance_covers_the_product():
    random = np.random.default_rng(9)
    found = []
    for _ in range(TRIALS):
        variance = 0.02 * random.gamma(50.0, 1 / 50.0, 16)
        seconds = 3.0 * random.lognormal(0.0, 0.03, 5)
        ttuv = timing.time_to_unit_variance(variance, 64, seconds, 32)
        found.append(timing.positive_interval(ttuv))
    # 64 samples an image of variance 0.02, 3 s for 32 samples: 0.02 * 64 * 3 / 32 s.
    assert coverage(found, 0.12) == pytest.approx(0.95, abs=SLACK + 0.015)


def test_efficiency_is_the_inverse_of_time_to_unit_variance():
    inverse = timing.efficiency(intervals.Interval(0.5, 0.25, 1.0, 8))
    assert (inverse.value, inverse.lower, inverse.upper) == (2.0, 1.0, 4.0)


def test_speed_does_not_depend_on_the_sample_count_of_the_timed_image():
    ratio = timing.speed_ratio([1.0, 1.0], 16, [8.0, 8.0], 64)
    assert ratio.value == pytest.approx(2.0)


def test_equal_times_give_an_interval_without_width():
    assert intervals.median_interval([2.0] * 3) == intervals.Interval(2.0, 2.0, 2.0, 3)
    assert intervals.log_ratio_interval([2.0, 2.0], [1.0, 1.0]).lower == pytest.approx(2.0)


def test_a_single_value_has_no_interval():
    assert np.isnan(intervals.t_interval([3.0]).lower)
    assert np.isnan(intervals.median_interval([3.0]).upper)


def test_a_time_of_zero_is_refused():
    with pytest.raises(ValueError, match="must be positive"):
        timing.throughput(1.0, [1.0, 0.0])


@pytest.mark.parametrize("degrees", [0.0, 0.3, 1, 2, 3, 7.5, 31, 1e3, 1e9, np.inf, np.nan])
def test_quantiles_and_tails_of_student_are_scipys_bit_for_bit(degrees: float):
    for p in (1e-9, 0.025, 0.5, 0.95, 0.975, 0.99999):
        own, theirs = intervals.student_quantile(p, degrees), stats.t.ppf(p, degrees)
        assert np.array_equal(own, theirs, equal_nan=True), (p, degrees, own, theirs)
    for t in (-np.inf, -3.0, 0.0, 0.1, 2.0, 40.0, np.inf, np.nan):
        own, theirs = intervals.student_tail(t, degrees), stats.t.sf(t, degrees)
        assert np.array_equal(own, theirs, equal_nan=True), (t, degrees, own, theirs)
