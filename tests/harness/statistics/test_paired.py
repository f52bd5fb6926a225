"""Turned knobs against images of the same seeds: unbiased, narrow, and scaled as they should."""

import numpy as np
import pytest
from scipy import stats

from harness.statistics.paired import (
    paired_relative_bias,
    paired_scale,
    products,
    squared_difference,
)

SHAPE = (8, 8, 3)
REPEATS = 400


def pairs(
    random: np.random.Generator, count: int, *, factor: float, own_noise: float
) -> tuple[np.ndarray, np.ndarray]:
    """Images of noise 0.5 around 1 and `factor` times the same ones with a little noise of their
    own.
    """
    exact = 1.0 + 0.5 * random.standard_normal((count, *SHAPE))
    return factor * exact + own_noise * random.standard_normal((count, *SHAPE)), exact


@pytest.mark.parametrize("factor", [1.0, 0.9])
def test_the_squared_difference_of_pairs_is_unbiased(factor: float) -> None:
    random = np.random.default_rng(11)
    weight = np.ones(SHAPE)
    found = np.array(
        [
            squared_difference(*pairs(random, 6, factor=factor, own_noise=0.1), weight).value
            for _ in range(REPEATS)
        ]
    )
    true = (factor - 1.0) ** 2
    error = stats.sem(found)
    # Four standard errors: one right test in 16,000 fails.
    assert abs(found.mean() - true) < 4.0 * error, (found.mean(), true, error)


def test_the_interval_of_a_squared_difference_holds_it() -> None:
    random = np.random.default_rng(12)
    weight = np.ones(SHAPE)
    held = 0
    for _ in range(REPEATS):
        images = pairs(random, 8, factor=0.9, own_noise=0.1)
        interval = squared_difference(*images, weight).interval()
        held += interval.lower <= 0.01 <= interval.upper
    # 380 of 400 nominal 95 % intervals do, less four standard deviations of that count.
    assert held >= 362, held


def test_equal_images_differ_by_nothing_and_without_doubt() -> None:
    images = np.random.default_rng(13).random((4, *SHAPE))
    found = squared_difference(images, images, np.ones(SHAPE))
    assert (found.value, found.error) == (0.0, 0.0)


def test_pairs_see_a_bias_that_single_images_do_not() -> None:
    # The jackknife of independent stacks errs by the noise of the means, 0.5^2 / 8 a pixel.
    random = np.random.default_rng(14)
    images, exact = pairs(random, 8, factor=0.99, own_noise=0.0)
    weight = np.ones(SHAPE)
    paired = squared_difference(images, exact, weight)
    shuffled = squared_difference(images, np.roll(exact, 1, axis=0), weight)
    assert paired.error < 0.05 * shuffled.error, (paired, shuffled)
    assert paired.value == pytest.approx(1e-4, rel=0.2)


def test_an_exposure_is_found_from_pairs_and_leaves_no_bias() -> None:
    images, exact = pairs(np.random.default_rng(15), 8, factor=0.8, own_noise=0.0)
    weight = np.ones(SHAPE)
    scale = paired_scale(images, exact, weight)
    assert scale == pytest.approx(1.25, rel=1e-12)
    assert squared_difference(images, exact, weight, scale).value == pytest.approx(0.0, abs=1e-12)
    assert paired_relative_bias(images, exact).value == pytest.approx(-0.2, abs=1e-12)
    assert paired_relative_bias(images, exact, scale).value == pytest.approx(0.0, abs=1e-12)


def test_black_images_keep_their_exposure() -> None:
    black = np.zeros((3, *SHAPE))
    assert paired_scale(black, black, np.ones(SHAPE)) == 1.0
    assert paired_relative_bias(black, black).value == 0.0


def test_products_are_weighted_means_over_pixels() -> None:
    random = np.random.default_rng(16)
    first, second, weight = random.random((2, *SHAPE)), random.random((2, *SHAPE)), np.ones(SHAPE)
    weight[0, 0] = 3.0
    expected = [[np.mean(weight * a * b) for b in second] for a in first]
    assert np.allclose(products(first, second, weight), expected, rtol=1e-12)


@pytest.mark.parametrize(("count", "others"), [(2, 2), (4, 3)])
def test_too_few_or_unequal_pairs_are_refused(count: int, others: int) -> None:
    with pytest.raises(ValueError, match="3 pairs"):
        squared_difference(np.ones((count, *SHAPE)), np.ones((others, *SHAPE)), np.ones(SHAPE))
