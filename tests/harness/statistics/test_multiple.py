"""Holm's procedure."""

import numpy as np

from harness.statistics.multiple import holm


def test_the_smallest_p_value_is_set_against_the_level_over_the_number_of_tests():
    # 0.001 <= 0.01 / 4, 0.004 > 0.01 / 3: the third would pass alone but comes after a failure.
    assert holm([0.5, 0.001, 0.004, 0.005], 0.01) == [False, True, False, False]


def test_after_a_rejection_fewer_hypotheses_are_left_to_pay_for():
    # 0.0024 <= 0.01 / 4 and then 0.0033 <= 0.01 / 3, which a plain quarter would not reject.
    assert holm([0.0033, 0.0024, 0.9, 0.8], 0.01) == [True, True, False, False]


def test_no_p_value_and_an_unknown_one_reject_nothing():
    assert holm([], 0.01) == []
    assert holm([float("nan"), 0.5], 0.01) == [False, False]


def test_true_hypotheses_are_rejected_no_more_often_than_stated():
    random = np.random.default_rng(1)
    trials = 4000
    wrong = sum(any(holm(list(random.uniform(size=20)), 0.05)) for _ in range(trials)) / trials
    # Four standard errors of a share of 0.05.
    assert wrong <= 0.05 + 4.0 * np.sqrt(0.0475 / trials), wrong
