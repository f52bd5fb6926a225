"""The equivalence gate: what it must pass, what it must not."""

import numpy as np
import pytest

from harness.statistics.bias import (
    Verdict,
    judge_equivalence,
    relative_bias,
    relative_difference,
    weighted_relative_bias,
)
from harness.statistics.intervals import Interval
from harness.statistics.metrics import make_truth

DELTA = 0.005


def means(random: np.random.Generator, value: float, spread: float, count: int) -> np.ndarray:
    return value * (1.0 + spread * random.standard_normal(count))


def judge_means(
    random: np.random.Generator, bias: float, spread: float, count: int = 16
) -> Verdict:
    test = means(random, 1.0 + bias, spread, count)
    truth = means(random, 1.0, 0.004, 16)
    return judge_equivalence(relative_difference(test, truth, 0.9), DELTA, 16).verdict


def test_a_planted_one_per_cent_error_fails():
    random = np.random.default_rng(1)
    verdicts = [judge_means(random, 0.01, 0.004) for _ in range(300)]
    assert verdicts.count(Verdict.PASS) == 0
    # The half-width is 0.25 %, so that the interval of a 1 % bias lies beyond 0.5 % nearly always.
    assert verdicts.count(Verdict.FAIL) >= 0.95 * len(verdicts)


def test_no_bias_passes():
    random = np.random.default_rng(2)
    verdicts = [judge_means(random, 0.0, 0.004) for _ in range(300)]
    assert verdicts.count(Verdict.FAIL) == 0
    assert verdicts.count(Verdict.PASS) >= 0.85 * len(verdicts)


def test_a_bias_on_the_bound_passes_in_at_most_five_per_cent():
    random = np.random.default_rng(3)
    trials = 4000
    verdicts = [judge_means(random, DELTA, 0.004) for _ in range(trials)]
    share = verdicts.count(Verdict.PASS) / trials
    assert share <= 0.05 + 4.0 * np.sqrt(0.05 * 0.95 / trials), share


def test_a_noisy_tracer_never_passes_for_want_of_evidence():
    random = np.random.default_rng(4)
    verdicts = {judge_means(random, 0.0, 0.05) for _ in range(100)}
    assert Verdict.PASS not in verdicts
    assert Verdict.NOT_ENOUGH_SAMPLES in verdicts


def test_the_seeds_asked_for_are_enough():
    random = np.random.default_rng(5)
    test, truth = means(random, 1.0, 0.02, 16), means(random, 1.0, 0.01, 16)
    first = judge_equivalence(relative_difference(test, truth, 0.9), DELTA, 16)
    assert first.verdict is Verdict.NOT_ENOUGH_SAMPLES
    assert first.seeds_needed is not None
    assert first.batches_needed is not None
    # Twice what is asked for, since the request rests on a bias that is itself uncertain.
    test = means(random, 1.0, 0.02, 2 * first.seeds_needed)
    truth = means(random, 1.0, 0.01, 2 * first.batches_needed)
    second = judge_equivalence(relative_difference(test, truth, 0.9), DELTA, truth.size)
    assert second.verdict is Verdict.PASS, second


@pytest.mark.parametrize(
    ("lower", "upper", "verdict"),
    [
        (-0.004, 0.004, Verdict.PASS),
        (-0.006, 0.004, Verdict.NOT_ENOUGH_SAMPLES),
        (0.004, 0.006, Verdict.NOT_ENOUGH_SAMPLES),
        (0.005, 0.006, Verdict.FAIL),
        (-0.02, -0.01, Verdict.FAIL),
        (float("inf"), float("inf"), Verdict.FAIL),
    ],
)
def test_the_verdict_follows_from_the_interval(lower: float, upper: float, verdict: Verdict):
    interval = Interval(0.5 * (lower + upper), lower, upper, 16)
    assert judge_equivalence(interval, DELTA, 16).verdict is verdict


def test_the_interval_of_the_bias_covers():
    random = np.random.default_rng(6)
    found = [
        relative_difference(means(random, 1.01, 0.03, 16), means(random, 1.0, 0.01, 16), 0.9)
        for _ in range(3000)
    ]
    share = np.mean([interval.lower <= 0.01 <= interval.upper for interval in found])
    assert share == pytest.approx(0.9, abs=4.0 * np.sqrt(0.09 / 3000) + 0.005)


def test_without_noise_the_bias_is_exact():
    image, truth = np.full((4, 8, 8, 3), 1.02), make_truth(np.ones((4, 8, 8, 3)))
    bias = relative_bias(image, truth)
    assert (bias.lower, bias.upper) == pytest.approx((0.02, 0.02))
    assert judge_equivalence(bias, DELTA, 4).verdict is Verdict.FAIL
    equal = relative_bias(np.ones((4, 8, 8, 3)), truth)
    assert judge_equivalence(equal, DELTA, 4).verdict is Verdict.PASS


def test_black_agrees_with_black_and_nothing_else_does():
    black = np.zeros(4)
    assert relative_difference(black, black).value == 0.0
    bias = relative_difference(np.ones(4), black, 0.9)
    assert judge_equivalence(bias, DELTA, 4).verdict is Verdict.FAIL


def test_one_seed_is_refused():
    with pytest.raises(ValueError, match="at least 2 seeds"):
        relative_difference(np.ones(1), np.ones(4))


def test_the_weighted_mean_is_sharper_and_leaves_lights_out():
    random = np.random.default_rng(7)
    mean = np.full((16, 16, 3), 0.5)
    mean[:3, 6:10] = 20.0
    sigma = np.where(mean > 1.0, 6.0, 0.05)
    truth = make_truth(mean + sigma * random.standard_normal((16, *mean.shape)))
    images = 1.01 * mean + sigma * random.standard_normal((16, *mean.shape))
    plain, weighted = relative_bias(images, truth), weighted_relative_bias(images, truth)
    assert weighted is not None
    assert weighted.half_width < 0.5 * plain.half_width
    assert weighted.lower <= 0.01 <= weighted.upper, weighted
