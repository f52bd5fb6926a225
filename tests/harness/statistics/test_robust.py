"""Quantiles over runs and effective pixels."""

import numpy as np
import pytest

from harness.statistics.robust import effective_pixels, quantile_interval


@pytest.mark.parametrize("quantile", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("count", [16, 64])
def test_the_interval_of_a_quantile_covers_at_least_its_level(quantile: float, count: int):
    random = np.random.default_rng(count)
    true = -np.log1p(-quantile)
    found = [quantile_interval(random.exponential(size=count), quantile) for _ in range(1000)]
    inside = np.mean([interval.lower <= true <= interval.upper for interval in found])
    assert inside >= 0.95 - 4.0 * np.sqrt(0.0475 / 1000), inside


def test_the_median_lies_between_the_order_statistics_of_the_textbook():
    # Conover's table: 6th and 15th of twenty values, 95.9 %.
    found = quantile_interval(np.arange(1.0, 21.0), 0.5)
    assert (found.value, found.lower, found.upper) == (10.5, 6.0, 15.0)


def test_an_end_that_the_values_do_not_reach_is_infinite():
    found = quantile_interval(np.arange(8.0), 0.9)
    assert found.upper == np.inf
    assert np.isfinite(found.lower)


def test_a_quantile_outside_of_its_range_is_refused():
    with pytest.raises(ValueError, match="between 0 and 1, got 1"):
        quantile_interval([1.0, 2.0], 1.0)


def test_pixels_of_equal_variance_all_count():
    random = np.random.default_rng(1)
    images = random.standard_normal((400, 16, 16, 3))
    # The noise of 399 degrees of freedom adds 2 / 399 to the mean of the squares.
    assert effective_pixels(images) == pytest.approx(256.0, rel=0.02)


def test_a_few_noisy_pixels_count_for_themselves():
    random = np.random.default_rng(2)
    images = 1e-3 * random.standard_normal((400, 16, 16, 3))
    images[:, 3, 4:8] *= 1e3
    assert effective_pixels(images) == pytest.approx(4.0, rel=0.05)


def test_images_that_do_not_vary_have_no_effective_pixels():
    assert np.isnan(effective_pixels(np.ones((4, 8, 8, 3))))
