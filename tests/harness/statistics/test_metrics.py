"""Metrics against closed forms."""

import numpy as np
import pytest

from harness.statistics import metrics

SEED = 20_261_122


def noisy(random: np.random.Generator, mean: np.ndarray, sigma: float, count: int) -> np.ndarray:
    return mean + sigma * random.standard_normal((count, *mean.shape))


@pytest.fixture
def mean() -> np.ndarray:
    return np.random.default_rng(SEED).uniform(0.2, 2.0, (24, 16, 3))


def exact_truth(mean: np.ndarray) -> metrics.Truth:
    return metrics.make_truth(np.stack([mean, mean]))


def test_mse_of_a_constant_offset_is_its_square(mean: np.ndarray):
    error = metrics.mse((mean + 0.25)[None], exact_truth(mean))
    assert error == pytest.approx([0.0625], rel=1e-12)


def test_relmse_of_a_constant_factor_has_its_closed_form():
    grey = np.full((8, 8, 3), 0.5)
    # epsilon = 1e-2 * 0.5^2, so (0.05)^2 / (0.25 + 0.0025).
    error = metrics.relmse((1.1 * grey)[None], exact_truth(grey))
    assert error == pytest.approx([0.0025 / 0.2525], rel=1e-6)


def test_relmse_sees_a_light_leak_where_the_truth_is_black():
    truth = np.full((10, 10, 3), 1.0)
    truth[:2] = 0.0
    image = truth.copy()
    image[:2] = 1.0
    expected = 0.2 / (1e-2 * 0.8**2)
    assert metrics.relmse(image[None], exact_truth(truth)) == pytest.approx([expected], rel=1e-5)


def test_smape_is_two_for_opposites_and_zero_for_black_on_black():
    image = np.zeros((4, 4, 3))
    truth = np.zeros((4, 4, 3))
    truth[:2] = 1.0
    assert metrics.smape(image[None], exact_truth(truth)) == pytest.approx([1.0])
    assert metrics.smape(truth[None], exact_truth(truth)) == pytest.approx([0.0])


def test_epsilon_is_a_hundredth_of_the_squared_mean_luminance():
    truth = exact_truth(np.full((4, 4, 3), 3.0))
    assert truth.epsilon == pytest.approx(0.09, rel=1e-5)


def test_a_black_truth_gives_a_plain_mse():
    black = exact_truth(np.zeros((4, 4, 3)))
    assert metrics.relmse(np.full((1, 4, 4, 3), 0.5), black) == pytest.approx([0.25])


def test_the_truths_noise_is_removed_from_every_squared_error():
    random = np.random.default_rng(SEED)
    mean = random.uniform(0.5, 2.0, (24, 16, 3))
    errors, relative = [], []
    for _ in range(40):
        truth = metrics.make_truth(noisy(random, mean, 0.2, 16))
        images = noisy(random, mean, 0.05, 4)
        errors.append(metrics.mse(images, truth).mean())
        relative.append(metrics.relmse(images, truth).mean())
    # The noise removed, 0.2^2 / 16, is as large as the error itself, 0.05^2.
    tolerance = 4.0 * np.std(errors) / np.sqrt(40)
    assert np.mean(errors) == pytest.approx(0.0025, abs=tolerance), (errors, tolerance)
    epsilon = 1e-2 * metrics.luminance(mean).mean() ** 2
    expected = 0.0025 * np.mean(1.0 / (mean**2 + epsilon))
    # The weight is itself taken at a noisy r; its errors are of the order s_r^2 / (R r^2), 1 %.
    assert np.mean(relative) == pytest.approx(expected, rel=0.05), (np.mean(relative), expected)


@pytest.mark.parametrize("offset", [0.0, 0.1])
def test_the_split_recovers_variance_and_bias(mean: np.ndarray, offset: float):
    random = np.random.default_rng(SEED)
    variances, biases = [], []
    for _ in range(60):
        truth = metrics.make_truth(noisy(random, mean, 0.2, 16))
        split = metrics.split_error(noisy(random, mean + offset, 0.3, 8), truth, relative=False)
        variances.append(split.variance.value)
        biases.append(split.bias_squared)
    for name, values, expected in (
        ("variance", variances, 0.09),
        ("bias", biases, offset**2),
    ):
        tolerance = 4.0 * np.std(values) / np.sqrt(len(values))
        assert np.mean(values) == pytest.approx(expected, abs=tolerance), (name, np.mean(values))


def test_the_split_adds_up_to_the_mean_squared_error(mean: np.ndarray):
    random = np.random.default_rng(SEED)
    truth = metrics.make_truth(noisy(random, mean, 0.2, 16))
    images = noisy(random, mean + 0.05, 0.3, 8)
    for relative, metric in ((False, metrics.mse), (True, metrics.relmse)):
        split = metrics.split_error(images, truth, relative=relative)
        total = split.variance.value + split.bias_squared
        assert total == pytest.approx(metric(images, truth).mean(), rel=1e-9)


@pytest.mark.parametrize(("offset", "most"), [(0.05, 1.8), (0.5, 1.15)])
def test_the_error_of_the_bias_is_its_spread_or_more(mean: np.ndarray, offset: float, most: float):
    random = np.random.default_rng(SEED)
    truth = exact_truth(mean)
    splits = [
        metrics.split_error(noisy(random, mean + offset, 0.3, 8), truth, relative=False)
        for _ in range(150)
    ]
    spread = np.std([split.bias_squared for split in splits])
    claimed = np.sqrt(np.mean([split.bias_squared_error**2 for split in splits]))
    # A standard deviation of 150 values is known to 6 %.
    assert 0.85 <= claimed / spread <= most, (claimed, spread)


def test_every_bad_pixel_is_counted_once():
    images = np.ones((2, 4, 4, 3))
    images[0, 0, 0] = np.nan
    images[1, 1, 1, 2] = np.inf
    images[1, 2, 2, 0] = -1e-9
    images[0, 3, 3] = -0.0
    assert metrics.count_defects(images) == metrics.Defects(2, 1, 32)


def test_a_truth_of_one_batch_is_refused():
    with pytest.raises(ValueError, match="at least 2 batches"):
        metrics.make_truth(np.ones((1, 4, 4, 3)))
