"""Verdicts on a variance and a speed, against those of before."""

import math

import numpy as np
import pytest

from harness.statistics.bias import Verdict
from harness.statistics.change import Speed, judge_speed, judge_variance
from harness.statistics.estimate import Estimate, log_ratio_of_means


def log_ratio(ratio: float, error: float) -> Estimate:
    return Estimate(math.log(ratio), error, 15.0, 16)


@pytest.mark.parametrize(
    ("ratio", "error", "verdict"),
    [
        (1.0, 0.05, Verdict.PASS),
        (0.3, 0.3, Verdict.PASS),
        (2.0, 0.1, Verdict.FAIL),
        # Beyond the margin, but by chance: 1.3 is 2.6 errors from 1.
        (1.3, 0.1, Verdict.NOT_ENOUGH_SAMPLES),
        (1.0, 0.5, Verdict.NOT_ENOUGH_SAMPLES),
    ],
)
def test_a_variance_is_judged_by_its_ratio(ratio: float, error: float, verdict: Verdict):
    assert judge_variance(log_ratio(ratio, error), 1.25, 1e-4).verdict is verdict


def test_the_seeds_asked_for_settle_the_variance():
    found = judge_variance(log_ratio(1.0, 0.2), 1.25, 1e-4)
    assert found.seeds_needed is not None
    smaller = Estimate(0.0, 0.2 * math.sqrt(16 / (1.1 * found.seeds_needed)), 15.0, 16)
    assert judge_variance(smaller, 1.25, 1e-4).verdict is Verdict.PASS


def test_noise_where_there_was_none_fails_and_none_where_there_was_passes():
    noise, none = np.ones(8), np.zeros(8)
    worse = log_ratio_of_means(noise, none, paired=True)
    assert judge_variance(worse, 1.25, 1e-4).verdict is Verdict.FAIL
    better = log_ratio_of_means(none, noise, paired=True)
    assert judge_variance(better, 1.25, 1e-4).verdict is Verdict.PASS
    assert judge_variance(log_ratio_of_means(none, none, paired=True), 1.25, 1e-4).verdict is (
        Verdict.PASS
    )


@pytest.mark.parametrize(
    ("ratio", "error", "speed"),
    [
        (1.0, 0.02, Speed.SAME),
        (0.95, 0.01, Speed.SAME),
        (0.8, 0.02, Speed.SLOWER),
        (1.3, 0.02, Speed.FASTER),
        (0.8, 0.06, Speed.AMBIGUOUS),
        (0.9, 0.02, Speed.AMBIGUOUS),
        (1.0, 0.2, Speed.AMBIGUOUS),
        (1.0, math.nan, Speed.AMBIGUOUS),
    ],
)
def test_a_speed_is_named_only_where_it_is_known(ratio: float, error: float, speed: Speed):
    assert judge_speed(log_ratio(ratio, error), 0.1, 1e-4) is speed
