"""What differs between two measurements of one thing, now and before."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from harness.statistics.bias import Verdict
from harness.statistics.estimate import Estimate
from harness.statistics.intervals import Interval

LEVEL = 0.90
"""Two one-sided tests at 5 % are the 90 % interval (Schuirmann 1987)."""


class Speed(Enum):
    """What is said of a time; no verdict is forced on one that varies too much."""

    FASTER = "faster"
    SAME = "same"
    SLOWER = "slower"
    AMBIGUOUS = "ambiguous"


@dataclass(frozen=True, slots=True)
class VarianceChange:
    """Verdict on a variance, against that of before."""

    verdict: Verdict
    ratio: Interval
    """of now to before, the 90 % interval"""
    margin: float
    seeds_needed: int | None


def judge_variance(log_ratio: Estimate, margin: float, strict: float) -> VarianceChange:
    """PASS where the ratio is proven to be below `margin`, FAIL where it is proven to exceed 1.

    log_ratio: of the variance now to that of before (`log_ratio_of_means`). The first proof is one
    of the two one-sided tests of equivalence; a lower variance is no failure. The second holds at
    the level `strict` of a family of tests and is asked where the first fails. Otherwise the seeds
    needed follow from a half-width that falls with the square root of their number.
    """
    ratio = log_ratio.ratio(LEVEL)
    if ratio.upper < margin:
        return VarianceChange(Verdict.PASS, ratio, margin, None)
    if log_ratio.value > 0.0 and log_ratio.p_value() < strict:
        return VarianceChange(Verdict.FAIL, ratio, margin, None)
    room = abs(math.log(margin) - log_ratio.value)
    half = log_ratio.interval(LEVEL).half_width
    factor = (half / max(room, 0.05 * math.log(margin))) ** 2
    needed = math.ceil(log_ratio.n * max(factor, 1.0))
    return VarianceChange(Verdict.NOT_ENOUGH_SAMPLES, ratio, margin, needed)


def judge_speed(log_ratio: Estimate, margin: float, strict: float) -> Speed:
    """Compare a speed with that of before: log_ratio is of now to before, above 0 if faster.

    `same` where the 90 % interval lies within a factor of 1 +- margin, `faster` or `slower` where
    it lies outside and equal speeds are rejected at the level `strict` of a family of tests, else
    ambiguous. Repeats of one run vary less than runs do (alignment, heat, neighbours: Mytkowicz et
    al. 2009, Producing Wrong Data Without Doing Anything Obviously Wrong), so that a margin of zero
    would call every second clean run a change.
    """
    found = log_ratio.interval(LEVEL)
    bound = math.log1p(margin)
    if -bound < found.lower and found.upper < bound:
        return Speed.SAME
    if log_ratio.p_value() < strict:
        if found.lower >= bound:
            return Speed.FASTER
        if found.upper <= -bound:
            return Speed.SLOWER
    return Speed.AMBIGUOUS
