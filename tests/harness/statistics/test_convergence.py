"""The slope of convergence: value, coverage, and what flattens it."""

import numpy as np
import pytest

from harness.statistics.convergence import fit_slope, spread_of_errors

COUNTS = [2**k for k in range(7)]


def simulate(
    random: np.random.Generator, seeds: int, bias: float = 0.0, spread: float = 0.1
) -> dict[int, np.ndarray]:
    shape = 1.0 / spread**2
    return {n: bias + random.gamma(shape, 1.0 / (n * shape), seeds) for n in COUNTS}


def test_an_exact_power_law_gives_its_exponent():
    fit = fit_slope({n: np.full(3, 0.5 * n**-1.25) for n in COUNTS}, 0.0)
    assert fit.slope.value == pytest.approx(-1.25)
    assert fit.at(8.0) == pytest.approx(0.5 * 8.0**-1.25)


@pytest.mark.parametrize("seeds", [2, 4, 8])
def test_the_interval_of_the_slope_covers(seeds: int):
    random = np.random.default_rng(seeds)
    trials = 1500
    fits = [fit_slope(simulate(random, seeds), 0.0).slope for _ in range(trials)]
    share = np.mean([fit.lower <= -1.0 <= fit.upper for fit in fits])
    # Widening to the scatter of the points makes it cover a little more than stated.
    assert 0.95 - 4.0 * np.sqrt(0.0475 / trials) <= share <= 0.99, share


def test_an_outlier_widens_the_interval():
    errors = simulate(np.random.default_rng(4), 4)
    clean = fit_slope(errors, 0.0).slope
    errors[1] = 5.0 * errors[1]
    slope = fit_slope(errors, 0.0).slope
    assert slope.value < clean.lower, (clean, slope)
    assert slope.lower <= -1.0 <= slope.upper, (clean, slope)


def test_rare_bright_samples_are_charged_to_the_counts_that_have_them():
    """Gamma errors with squared coefficient of variation a + b / n: weights must follow it."""
    random = np.random.default_rng(5)
    a, b = 0.004, 0.4
    errors = {n: random.gamma(1.0 / (a + b / n), (a + b / n) / n, size=4000) for n in COUNTS}
    spread = spread_of_errors(errors, 0.0)
    for n in COUNTS:
        # A squared coefficient of variation from 4000 gamma values errs by under 5 %.
        assert spread(n) == pytest.approx(a + b / n, rel=0.1), n


def test_bias_flattens_the_slope():
    fit = fit_slope(simulate(np.random.default_rng(1), 4, bias=0.05), 0.0)
    assert fit.slope.lower > -0.9


def test_points_below_the_truths_noise_are_dropped():
    random = np.random.default_rng(2)
    # The noise, 1.0, hides everything from 16 samples on (1/16 < 0.1 / 0.9).
    errors = {n: values + random.normal(0.0, 0.002, 4) for n, values in simulate(random, 4).items()}
    fit = fit_slope(errors, 1.0)
    assert fit.dropped == (16, 32, 64), fit
    assert fit.slope.lower <= -1.0 <= fit.slope.upper


def test_two_points_are_no_slope():
    with pytest.raises(ValueError, match="at least 3"):
        fit_slope({1: np.ones(4), 2: np.ones(4)}, 0.0)
    with pytest.raises(ValueError, match="at least 3"):
        fit_slope({n: np.zeros(4) for n in COUNTS}, 0.0)


def test_one_seed_a_count_has_a_slope_without_an_interval():
    fit = fit_slope(simulate(np.random.default_rng(3), 1), 0.0)
    assert np.isfinite(fit.slope.value)
    assert np.isnan(fit.slope.lower)
