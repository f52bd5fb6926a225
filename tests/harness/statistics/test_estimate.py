"""Estimates and what is made of them: exact examples and coverage."""

import math

import numpy as np
import pytest
from scipy import stats

from harness.statistics.estimate import (
    Estimate,
    combine,
    exactly,
    log_of,
    log_ratio_of_means,
    mean_of,
    product_of_means,
    ratio_to_nonnegative,
)


def test_the_interval_of_a_mean_equals_the_textbook():
    found = mean_of([1.0, 2.0, 3.0, 4.0])
    half = stats.t.ppf(0.975, 3) * np.std([1, 2, 3, 4], ddof=1) / 2.0
    assert (found.value, found.interval().half_width) == pytest.approx((2.5, half))


def test_the_p_value_equals_scipy_s():
    values = np.random.default_rng(1).normal(0.4, 1.0, 12)
    expected = stats.ttest_1samp(values, 0.0).pvalue
    assert mean_of(values).p_value() == pytest.approx(expected)


def test_a_slack_as_large_as_the_value_leaves_no_evidence():
    found = Estimate(1e-6, 1e-9, 15.0, 16)
    assert found.p_value() < 1e-12
    assert found.p_value(slack=1e-5) == 1.0


def test_a_difference_of_means_is_welch_s():
    random = np.random.default_rng(2)
    a, b = random.normal(0.0, 1.0, 9), random.normal(0.3, 4.0, 17)
    found = combine([(1.0, mean_of(a)), (-1.0, mean_of(b))])
    expected = stats.ttest_ind(a, b, equal_var=False)
    assert found.p_value() == pytest.approx(expected.pvalue)
    assert found.degrees == pytest.approx(expected.df)


def test_an_exact_number_adds_no_error():
    own = mean_of([1.0, 2.0, 4.0])
    found = combine([(2.0, own), (1.0, exactly(5.0))])
    assert found.value == pytest.approx(2.0 * own.value + 5.0)
    assert (found.error, found.degrees, found.n) == pytest.approx((2.0 * own.error, 2.0, 3))


def test_a_single_value_has_no_error():
    found = combine([(1.0, mean_of([3.0])), (1.0, mean_of([1.0, 2.0]))])
    assert found.value == 4.5
    assert math.isnan(found.error)


def test_the_relative_errors_of_a_product_add_up():
    a, b = [9.0, 10.0, 11.0], [1.9, 2.0, 2.1]
    found = product_of_means(a, b)
    expected = 20.0 * math.hypot(mean_of(a).error / 10.0, mean_of(b).error / 2.0)
    assert (found.value, found.error) == pytest.approx((20.0, expected))


def test_the_logarithm_of_a_negative_estimate_is_refused():
    with pytest.raises(ValueError, match="not negative, got -1"):
        log_of(exactly(-1.0))


def test_paired_samples_that_are_equal_differ_by_nothing():
    values = np.random.default_rng(3).gamma(2.0, size=8)
    found = log_ratio_of_means(values, values, paired=True)
    assert (found.value, found.error, found.p_value()) == (0.0, 0.0, 1.0)


def test_pairing_sees_a_difference_that_the_seeds_hide():
    random = np.random.default_rng(4)
    old = random.gamma(4.0, size=16)
    new = 1.01 * old * random.lognormal(0.0, 1e-3, 16)
    assert log_ratio_of_means(new, old, paired=True).p_value() < 1e-6
    assert log_ratio_of_means(new, old, paired=False).p_value() > 0.5


@pytest.mark.parametrize("paired", [True, False])
def test_the_ratio_of_independent_samples_covers_either_way(paired: bool):
    random = np.random.default_rng(5)
    trials, inside = 2000, 0
    for _ in range(trials):
        found = log_ratio_of_means(
            random.gamma(16.0, 1.5, 16), random.gamma(16.0, 1.0, 16), paired=paired
        ).ratio()
        inside += found.lower <= 1.5 <= found.upper
    # Four standard errors of a share of 0.95, and the first order's own error.
    assert inside / trials == pytest.approx(0.95, abs=4.0 * np.sqrt(0.0475 / trials) + 0.01)


def test_black_is_as_bright_as_black_and_infinitely_darker_than_anything_else():
    black, grey = np.zeros(4), np.ones(4)
    assert log_ratio_of_means(black, black, paired=True).p_value() == 1.0
    brighter = log_ratio_of_means(grey, black, paired=True)
    assert brighter.value == math.inf
    assert brighter.p_value() == 0.0
    assert log_ratio_of_means(black, grey, paired=False).ratio().value == 0.0


def test_samples_of_different_sizes_are_not_paired():
    with pytest.raises(ValueError, match="3 values cannot be paired with 4"):
        log_ratio_of_means(np.ones(3), np.ones(4), paired=True)


def test_the_ratio_s_interval_is_fieller_s():
    top, bottom = Estimate(10.0, 1.0, math.inf, 9), Estimate(5.0, 0.5, math.inf, 9)
    found = ratio_to_nonnegative(top, bottom)
    assert found.value == 2.0
    for end in (found.lower, found.upper):
        distance = abs(10.0 - end * 5.0) / math.hypot(1.0, end * 0.5)
        assert distance == pytest.approx(stats.norm.ppf(0.975)), end


@pytest.mark.parametrize(("sign", "ends"), [(1.0, (True, False)), (-1.0, (False, True))])
def test_a_bottom_that_may_be_zero_leaves_one_end_open(sign: float, ends: tuple[bool, bool]):
    top = Estimate(10.0 * sign, 1.0, math.inf, 9)
    for value in (0.1, 0.0, -0.3):
        found = ratio_to_nonnegative(top, Estimate(value, 0.2, math.inf, 9))
        assert (math.isfinite(found.lower), math.isfinite(found.upper)) == ends, (value, found)
        nearest = found.lower if sign > 0.0 else found.upper
        assert sign * nearest > 0.0, found


def test_nothing_is_said_of_a_ratio_of_two_numbers_that_may_be_zero():
    found = ratio_to_nonnegative(Estimate(0.1, 1.0, 15.0, 16), Estimate(0.1, 1.0, 15.0, 16))
    assert (found.lower, found.upper) == (-math.inf, math.inf)


def test_the_ratio_of_exact_numbers_has_no_width():
    assert ratio_to_nonnegative(exactly(6.0), exactly(3.0)).half_width == 0.0
    assert ratio_to_nonnegative(exactly(6.0), exactly(0.0)).lower == math.inf
