"""Seeds that share their random numbers are found, independent ones are not accused."""

import numpy as np
import pytest

from harness.statistics.independence import strongest_correlation

SHAPE = (32, 32, 3)


def noise(random: np.random.Generator, count: int = 16) -> np.ndarray:
    """Skewed pixels: a few samples each."""
    return random.gamma(0.5, 2.0, (count, *SHAPE))


@pytest.mark.parametrize("count", [3, 4, 16])
def test_independent_seeds_are_rejected_no_more_often_than_stated(count: int):
    random = np.random.default_rng(count)
    level, trials = 0.01, 500
    p = [strongest_correlation(noise(random, count)) for _ in range(trials)]
    rejected = sum(found.p * found.pairs < level for found in p if found is not None)
    assert rejected <= 14, f"{rejected} of {trials} at {level}: the 99.9 % quantile is 13"


def test_two_seeds_that_share_a_quarter_of_their_samples_are_found():
    random = np.random.default_rng(2)
    images = noise(random)
    images[9] = 0.75 * images[9] + 0.25 * images[4]
    found = strongest_correlation(images)
    assert found is not None
    assert (found.first, found.second) == (4, 9)
    assert found.p * found.pairs < 1e-6, found


def test_one_bright_pixel_in_common_is_no_correlation():
    random = np.random.default_rng(3)
    images = noise(random)
    images[4, 7, 7] = images[9, 7, 7] = 1e4
    found = strongest_correlation(images)
    assert found is not None
    assert found.p * found.pairs > 1e-3, found


def test_images_that_hardly_vary_are_not_judged():
    images = np.ones((8, *SHAPE))
    images[:, 3, 3] += np.arange(8.0)[:, None]
    assert strongest_correlation(images) is None


def test_two_images_are_refused():
    with pytest.raises(ValueError, match="at least 3 images, got 2"):
        strongest_correlation(np.ones((2, *SHAPE)))
