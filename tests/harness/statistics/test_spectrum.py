"""The error spectrum: Parseval's sum, level for white noise, high where an error has a shape."""

import numpy as np
import pytest

from harness.statistics.metrics import Truth, luminance, make_truth
from harness.statistics.spectrum import (
    ensemble,
    error_spectra,
    radial_frequencies,
    truth_spectrum,
)

SIDE, RUNS, SIGMA = 64, 32, 0.1


def noisy(random: np.random.Generator, count: int, sigma: float) -> np.ndarray:
    """Grey images of mean 1 whose pixels are independent: [count, SIDE, SIDE, 3]."""
    return 1.0 + sigma * random.standard_normal((count, SIDE, SIDE, 1)) * np.ones(3)


@pytest.fixture(scope="module")
def truth() -> Truth:
    return make_truth(noisy(np.random.default_rng(1), 16, 0.01))


def test_white_noise_is_level_at_its_relative_variance(truth: Truth):
    spectra = error_spectra(noisy(np.random.default_rng(2), RUNS, SIGMA), truth)
    frequencies, ring = radial_frequencies(SIDE, SIDE)
    assert spectra.shape == (RUNS, len(frequencies)) == (RUNS, SIDE // 2)
    level = SIGMA**2 / 1.01 + truth_spectrum(truth)
    counts = np.bincount(ring[ring >= 0])
    # Power in a bin is exponential; those of opposite frequencies are equal.
    error = 5.0 * level / np.sqrt(0.5 * counts * RUNS)
    assert (np.abs(spectra.mean(axis=0) - level) < error).all(), spectra.mean(axis=0)


def test_the_mean_over_all_frequencies_is_the_relative_error(truth: Truth):
    images = noisy(np.random.default_rng(3), 1, SIGMA)
    reference = luminance(truth.mean)
    error = (luminance(images[0]) - reference) / np.sqrt(reference**2 + truth.epsilon)
    power = np.abs(np.fft.fft2(error)) ** 2 / error.size
    assert power.mean() == pytest.approx((error**2).mean(), rel=1e-12)
    _, ring = radial_frequencies(SIDE, SIDE)
    rings = [power[ring == k].mean() for k in range(ring.max() + 1)]
    np.testing.assert_allclose(error_spectra(images, truth)[0], rings, rtol=1e-12)


def test_a_bias_with_a_shape_stands_at_its_frequency_and_nowhere_else(truth: Truth):
    cycles = 3
    wave = 0.2 * np.sin(2.0 * np.pi * cycles * np.arange(SIDE) / SIDE)[None, :, None]
    spectra = error_spectra(noisy(np.random.default_rng(4), RUNS, SIGMA) + wave, truth).mean(axis=0)
    assert int(np.argmax(spectra)) == cycles - 1
    others = np.delete(spectra, cycles - 1)
    assert spectra[cycles - 1] > 10.0 * others.max(), spectra


def test_bands_are_runs_in_the_order_of_their_error(truth: Truth):
    random = np.random.default_rng(5)
    images = np.concatenate([noisy(random, 10, SIGMA), noisy(random, 1, 5.0 * SIGMA)])
    runs = ensemble(error_spectra(images, truth), (0.0, 0.1, 0.5, 0.9, 1.0))
    assert len(runs) == 5
    means = runs.mean(axis=1)
    assert (np.diff(means) >= 0.0).all(), means
    assert means[-1] > 10.0 * means[2], means


def test_an_image_that_is_not_square_ends_at_half_a_cycle_a_pixel():
    frequencies, ring = radial_frequencies(24, 40)
    assert frequencies[-1] == pytest.approx(0.5)
    assert ring.shape == (24, 40) and ring[0, 0] == -1
    assert set(np.unique(ring)) == set(range(-1, len(frequencies)))
