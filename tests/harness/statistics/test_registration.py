"""The shift of a picture: found where there is one, and never where there is none."""

import numpy as np
import pytest
from scipy import ndimage

from harness.statistics.metrics import make_truth
from harness.statistics.registration import find_shift


def picture() -> np.ndarray:
    """A disk before a slope, at eight times the film's resolution: [256, 256, 3]."""
    y, x = np.mgrid[0:256, 0:256] / 256.0
    light = 0.3 + 0.2 * x + 0.6 * ((x - 0.4) ** 2 + (y - 0.55) ** 2 < 0.06)
    return np.repeat(light[..., None], 3, axis=-1)


def film(shift: tuple[float, float]) -> np.ndarray:
    """The picture moved down and right by pixels of the film, box-filtered to [32, 32, 3]."""
    moved = ndimage.shift(picture(), (8.0 * shift[0], 8.0 * shift[1], 0.0), order=1, mode="nearest")
    return moved.reshape(32, 8, 32, 8, 3).mean(axis=(1, 3))


def noisy(random: np.random.Generator, mean: np.ndarray, count: int, spp: int) -> np.ndarray:
    return random.gamma(spp, mean / spp, (count, *mean.shape))


@pytest.mark.parametrize("shift", [(0.5, 0.0), (0.0, -0.5), (0.25, 0.25)])
def test_a_shift_is_measured_in_pixels(shift: tuple[float, float]):
    random = np.random.default_rng(1)
    truth = make_truth(noisy(random, film((0.0, 0.0)), 16, 256))
    found = find_shift(noisy(random, film(shift), 16, 64), truth)
    assert found is not None
    # A central difference sees half of a step's contrast on two pixels: first order, to a third.
    expected = (shift[1], shift[0])
    assert (found.right.value, found.down.value) == pytest.approx(expected, rel=0.34, abs=0.05)


def test_the_interval_of_no_shift_covers():
    random = np.random.default_rng(2)
    trials, inside, still = 300, 0, film((0.0, 0.0))
    for _ in range(trials):
        truth = make_truth(noisy(random, still, 16, 32))
        found = find_shift(noisy(random, still, 16, 16), truth)
        assert found is not None
        interval = found.right.interval()
        inside += interval.lower <= 0.0 <= interval.upper
    assert inside / trials == pytest.approx(0.95, abs=4.0 * np.sqrt(0.0475 / trials))


def test_a_picture_without_edges_lies_anywhere():
    random = np.random.default_rng(3)
    grey = np.full((16, 16, 3), 0.5)
    assert find_shift(np.stack([grey] * 4), make_truth(np.stack([grey] * 4))) is None
    # Stripes say nothing about the direction along them.
    stripes = grey * (1.0 + np.sin(np.arange(16.0)))[None, :, None]
    truth = make_truth(np.stack([stripes] * 4))
    assert find_shift(stripes + random.normal(0.0, 0.1, (4, 16, 16, 3)), truth) is None
