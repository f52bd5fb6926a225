"""The law of a launch on times that are made up, where the right answer is known."""

import numpy as np
import pytest
from scipy import special, stats

from harness.statistics.launch_law import SIGNIFICANT, fit_launch_law, runs_p_value

SIZES = 2.0 ** np.arange(8, 25)
EMPTY, RATE = 4e-5, 2e9
TRIALS = 400


def noisy_times(
    rng: np.random.Generator, times: np.ndarray, noise: float = 0.03, repeats: int = 3
) -> list[list[float]]:
    """Repeats of times with a relative error."""
    return [list(t * (1.0 + noise * rng.standard_normal(repeats))) for t in times]


def test_a_law_without_noise_is_found_exactly():
    law = fit_launch_law(SIZES, [[t] for t in EMPTY + SIZES / RATE])
    assert law.launch_seconds.value == pytest.approx(EMPTY, rel=1e-9)
    assert law.r_inf.value == pytest.approx(RATE, rel=1e-9)
    assert law.n_half.value == pytest.approx(EMPTY * RATE, rel=1e-9)
    assert law.share(law.n_half.value) == pytest.approx(0.5)


def test_points_may_come_in_any_order():
    rng = np.random.default_rng(5)
    times = noisy_times(rng, EMPTY + SIZES / RATE)
    law = fit_launch_law(SIZES, times)
    order = rng.permutation(SIZES.size)
    assert fit_launch_law(SIZES[order], [times[i] for i in order]) == law


def test_intervals_cover_what_they_claim_to():
    rng = np.random.default_rng(11)
    truth = {"launch_seconds": EMPTY, "r_inf": RATE, "n_half": EMPTY * RATE}
    covered = dict.fromkeys(truth, 0)
    for _ in range(TRIALS):
        law = fit_launch_law(SIZES, noisy_times(rng, EMPTY + SIZES / RATE))
        for name, value in truth.items():
            interval = getattr(law, name)
            covered[name] += interval.lower <= value <= interval.upper
    # 95 % of the trials, with the counts that chance allows once in ten thousand.
    least, most = stats.binom.ppf([5e-5, 1 - 5e-5], TRIALS, 0.95)
    for name, count in covered.items():
        assert least <= count <= most, f"{name}: {count} of {TRIALS} intervals cover"


def test_a_straight_law_is_rarely_called_bent():
    rng = np.random.default_rng(12)
    bent = 0
    for _ in range(TRIALS):
        bent += fit_launch_law(SIZES, noisy_times(rng, EMPTY + SIZES / RATE)).kink.significant
    most = stats.binom.ppf(1 - 1e-4, TRIALS, SIGNIFICANT)
    assert bent <= most, f"{bent} of {TRIALS} straight laws are called bent"


@pytest.mark.parametrize("place", [2**16, 2**20])
def test_a_kink_is_reported_where_it_is(place: int):
    # From the kink on a ray takes twice as long, as where packets leave a cache.
    rng = np.random.default_rng(13)
    times = EMPTY + SIZES / RATE + np.maximum(SIZES - place, 0.0) / RATE
    law = fit_launch_law(SIZES, noisy_times(rng, times, noise=0.02))
    assert law.kink.significant, law
    assert place / 4 <= law.kink.rays <= place * 4, law.kink
    assert law.kink.slope_after / law.kink.slope_before == pytest.approx(2.0, rel=0.2), law.kink


def test_a_floor_under_small_launches_is_a_kink():
    # A chip that is not full takes as long for one ray as for all that it holds.
    rng = np.random.default_rng(14)
    times = np.maximum(EMPTY, EMPTY + (SIZES - 2**17) / RATE)
    law = fit_launch_law(SIZES, noisy_times(rng, times, noise=0.02))
    assert law.kink.significant, law
    assert law.kink.slope_before < 0.2 * law.kink.slope_after, law.kink
    assert law.runs_p_value < 0.05, law


def test_one_wild_repeat_in_three_moves_nothing_by_much():
    rng = np.random.default_rng(15)
    times = noisy_times(rng, EMPTY + SIZES / RATE, noise=0.01)
    for repeats in times[::4]:
        repeats[1] *= 10.0
    law = fit_launch_law(SIZES, times)
    assert law.r_inf.value == pytest.approx(RATE, rel=0.03), law
    assert law.launch_seconds.value == pytest.approx(EMPTY, rel=0.03), law


def test_launches_that_all_take_as_long_have_no_rate():
    rng = np.random.default_rng(16)
    small = 2.0 ** np.arange(1, 10)
    law = fit_launch_law(small, noisy_times(rng, np.full(small.size, EMPTY)))
    assert law.r_inf.upper == np.inf or law.r_inf.upper > 1e9, law


@pytest.mark.parametrize(
    ("sizes", "times", "words"),
    [
        ([1, 2, 4, 8], [[1.0]] * 4, "at least 5 sizes of launches, got 4"),
        ([0, 1, 2, 4, 8], [[1.0]] * 5, "must be positive"),
        ([1, 2, 4, 8, 16], [[1.0], [1.0], [0.0], [1.0], [1.0]], "must be positive"),
    ],
)
def test_what_cannot_be_fitted_is_refused(sizes: list, times: list, words: str):
    with pytest.raises(ValueError, match=words):
        fit_launch_law(sizes, times)


def test_runs_are_counted_exactly():
    # Of the arrangements of 4 and 5 signs two have 2 runs; each sign's block comes first in one.
    signs = np.array([1.0] * 4 + [-1.0] * 5)
    assert runs_p_value(signs) == pytest.approx(2.0 / special.comb(9, 4))
    alternating = np.array([1.0, -1.0] * 4 + [1.0])
    assert runs_p_value(alternating) == pytest.approx(1.0)
