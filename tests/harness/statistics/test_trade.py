"""Error at a time, time to an error and the crossover: closed forms, then coverage."""

import math

import numpy as np
import pytest

from harness.statistics import trade
from harness.statistics.estimate import Estimate, exactly
from harness.statistics.intervals import Interval
from harness.statistics.metrics import make_truth, split_error
from harness.statistics.timing import time_to_unit_variance

EXACT = Estimate(0.40, 0.01, 20.0, 16)
FAST = Estimate(0.10, 0.004, 20.0, 16)
BIAS = Estimate(0.03, 0.001, 15.0, 16)


def test_the_error_is_the_bias_and_the_variance_of_the_time():
    found = trade.error_at(2.0, BIAS, FAST)
    assert found.value == pytest.approx(0.03 + 0.05)
    assert found.error == pytest.approx(math.hypot(0.001, 0.002))


def test_at_the_crossover_both_errors_are_equal():
    seconds = trade.crossover_seconds(EXACT, FAST, BIAS)
    assert seconds.value == pytest.approx(10.0)
    exact = trade.error_at(seconds.value, exactly(0.0), EXACT)
    assert trade.error_at(seconds.value, BIAS, FAST).value == pytest.approx(exact.value)
    assert 9.0 < seconds.lower < 10.0 < seconds.upper < 11.2, seconds


def test_a_fast_variant_that_is_slower_never_wins():
    seconds = trade.crossover_seconds(FAST, EXACT, BIAS)
    assert seconds.upper < 0.0, seconds


def test_a_bias_that_may_be_none_may_win_forever():
    seconds = trade.crossover_seconds(EXACT, FAST, Estimate(0.001, 0.001, 15.0, 16))
    assert seconds.upper == math.inf
    assert seconds.lower > 50.0, seconds


def test_the_effort_brings_the_error_to_the_target():
    seconds = trade.effort_to_error(0.05, BIAS, FAST)
    assert seconds.value == pytest.approx(5.0)
    assert trade.error_at(seconds.value, BIAS, FAST).value == pytest.approx(0.05)
    assert seconds.lower < 5.0 < seconds.upper < 7.0, seconds


def test_no_time_brings_the_error_below_the_bias():
    assert trade.effort_to_error(0.02, BIAS, FAST) == Interval(math.inf, math.inf, math.inf, 16)


def test_a_bias_about_as_large_as_the_target_leaves_the_time_open():
    seconds = trade.effort_to_error(0.0295, BIAS, FAST)
    assert seconds.value == math.inf
    assert 0.0 < seconds.lower < math.inf, seconds


def test_a_speed_up_inverts_when_the_two_change_places():
    there, back = trade.speed_up(FAST, EXACT), trade.speed_up(EXACT, FAST)
    assert there.value == pytest.approx(4.0)
    assert (there.lower, there.upper) == pytest.approx((1.0 / back.upper, 1.0 / back.lower))


def test_a_time_of_zero_is_refused():
    with pytest.raises(ValueError, match="must be positive, got 0"):
        trade.error_at(0.0, BIAS, FAST)
    with pytest.raises(ValueError, match="positive times"):
        trade.speed_up(exactly(0.0), EXACT)


def test_the_scale_is_an_exposure_and_is_blind_to_noise():
    random = np.random.default_rng(1)
    mean = random.uniform(0.2, 1.0, (24, 24, 3))
    truth = make_truth(np.stack([mean, mean]))
    # Noise as large as the image: taken with its square, the scale would be 13 % too small.
    images = mean / 1.7 * random.gamma(1.0, 1.0, (8, *mean.shape))
    # The scale's standard error is 1 / sqrt(8 * 1728), as those of a mean of so many values.
    tolerance = 1.7 * 4.0 / np.sqrt(8 * mean.size)
    found = trade.least_squares_scale(images, truth)
    assert found == pytest.approx(1.7, abs=tolerance), (found, tolerance)


def test_a_black_image_keeps_its_scale():
    truth = make_truth(np.ones((2, 4, 4, 3)))
    assert trade.least_squares_scale(np.zeros((2, 4, 4, 3)), truth) == 1.0


def crossover_of_fabricated_images(random: np.random.Generator) -> Interval:
    """T* of images whose bias is 0.1 everywhere, of a quarter of the exact one's cost."""
    mean = np.full((12, 12, 3), 0.5)
    truth = make_truth(mean + 0.02 * random.standard_normal((16, *mean.shape)))
    right = mean + 0.2 * random.standard_normal((16, *mean.shape))
    exact = split_error(right, truth, relative=False)
    biased = mean + 0.1 + 0.1 * random.standard_normal((16, *mean.shape))
    fast = split_error(biased, truth, relative=False)
    seconds = [2.0 * random.lognormal(0.0, 0.02, 5) for _ in range(2)]
    ttuv = [
        time_to_unit_variance(split.variance_by_image, 16, times, 16)
        for split, times in zip((exact, fast), seconds, strict=True)
    ]
    return trade.crossover_seconds(*ttuv, trade.bias_squared_of(fast))


def test_the_interval_of_the_crossover_covers():
    random = np.random.default_rng(2)
    trials = 400
    found = [crossover_of_fabricated_images(random) for _ in range(trials)]
    # (0.04 - 0.01) * 2 s / 0.01, the spread of the times 1.0002 beyond it.
    inside = np.mean([interval.lower <= 6.0012 <= interval.upper for interval in found])
    # The jackknife errs on the safe side.
    assert 0.95 - 4.0 * np.sqrt(0.0475 / trials) <= inside <= 0.995, inside
