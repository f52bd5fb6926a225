"""Bias of the image mean and the equivalence gate.

A difference that is "not significant" proves nothing: a noisy renderer would always pass. The gate
therefore asks for the opposite proof, that the bias is small (Schuirmann 1987).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from harness.statistics.intervals import (
    Interval,
    standard_error,
    student_quantile,
    welch_degrees,
)
from harness.statistics.metrics import Image, Truth, luminance

GATE_LEVEL = 0.90
"""Two one-sided tests at 5 % are the 90 % interval (Schuirmann 1987)."""


class Verdict(Enum):
    """Outcome of a gate; the order is from good to bad."""

    PASS = "PASS"  # noqa: S105 - a verdict, no password
    NOT_ENOUGH_SAMPLES = "NOT ENOUGH SAMPLES"
    FAIL = "FAIL"


def exit_code_of(verdicts: Iterable[Verdict]) -> int:
    """0 if all pass or there is none, 1 if any fails, 2 if samples are missing and none fails."""
    found = set(verdicts)
    if Verdict.FAIL in found:
        return 1
    return 2 if Verdict.NOT_ENOUGH_SAMPLES in found else 0


@dataclass(frozen=True, slots=True)
class Equivalence:
    """Verdict of the two one-sided tests of |relative bias| < delta."""

    verdict: Verdict
    bias: Interval
    delta: float
    seeds_needed: int | None
    """seeds (and `batches_needed`) at which a verdict is expected; None once there is one"""
    batches_needed: int | None


def relative_difference(
    test: NDArray[np.float64], truth: NDArray[np.float64], level: float = 0.95
) -> Interval:
    """(mean test - mean truth) / mean truth of two independent samples [K] and [R].

    Welch's interval of the ratio of means, its variance by first-order error propagation:
    (s_x^2 / K + (x / r)^2 s_r^2 / R) / r^2. Two black samples agree; against a black truth any
    other difference is infinite. Raises ValueError for fewer than two values on a side.
    """
    if min(test.size, truth.size) < 2:
        raise ValueError(
            f"a relative bias needs at least 2 seeds and 2 batches, got {test.size}, {truth.size}"
        )
    mean_test, mean_truth = float(test.mean()), float(truth.mean())
    n = int(test.size)
    if mean_truth == 0.0:
        value = 0.0 if mean_test == 0.0 else math.inf
        return Interval(value, value, value, n)
    ratio = mean_test / mean_truth
    error_test = (standard_error(test) / mean_truth) ** 2
    error_truth = (ratio * standard_error(truth) / mean_truth) ** 2
    degrees = welch_degrees(error_test, test.size, error_truth, truth.size)
    half = student_quantile(0.5 + 0.5 * level, degrees) * math.sqrt(error_test + error_truth)
    return Interval(ratio - 1.0, ratio - 1.0 - half, ratio - 1.0 + half, n)


def image_means(images: Image) -> NDArray[np.float64]:
    """Mean luminance of each image: [K, h, w, 3] -> [K]."""
    return np.asarray(luminance(images).mean(axis=(1, 2)))


def relative_bias(images: Image, truth: Truth, level: float = 0.95) -> Interval:
    """Relative bias of the plain mean luminance of images [K, h, w, 3], with its interval."""
    return relative_difference(image_means(images), image_means(truth.batches), level)


def judge_equivalence(
    bias: Interval, delta: float, batches: int, strict: Interval | None = None
) -> Equivalence:
    """PASS if the interval lies inside +-delta, FAIL if it lies outside, else not enough samples.

    `bias` must be the 90 % interval for tests at 5 %. Where it is wider than the bound it lies
    outside by chance in one of ten right images, so that among many a failure asks for more: the
    interval `strict`, at the level of the family, must not hold 0. The seeds still needed follow
    from a half-width that falls with the square root of the count: K (half / | delta - |bias| |)^2,
    with the truth's batches grown by the same factor.
    """
    if -delta < bias.lower and bias.upper < delta:
        return Equivalence(Verdict.PASS, bias, delta, None, None)
    certain = strict is None or not strict.lower <= 0.0 <= strict.upper
    if certain and (bias.lower >= delta or bias.upper <= -delta):
        return Equivalence(Verdict.FAIL, bias, delta, None, None)
    margin = abs(delta - abs(bias.value))
    # A bias within 5 % of delta would ask for a number of seeds that nobody will render.
    factor = max((bias.half_width / max(margin, 0.05 * delta)) ** 2, 1.0)
    return Equivalence(
        Verdict.NOT_ENOUGH_SAMPLES,
        bias,
        delta,
        math.ceil(bias.n * factor),
        math.ceil(batches * factor),
    )


def light_pixels(truth: Truth) -> NDArray[np.bool_]:
    """Pixels [h, w] taken to see a light: far brighter than the scene, and their neighbours.

    Far brighter is eight times the median of the pixels that are not black. A stand-in for the
    visibility of lights, which the image does not hold; it only feeds the weighted mean.
    """
    light = luminance(truth.mean)
    lit = light[light > 0.0]
    if lit.size == 0:
        return np.zeros(light.shape, dtype=bool)
    return np.asarray(ndimage.binary_dilation(light > 8.0 * np.median(lit), np.ones((3, 3))))


def weighted_relative_bias(images: Image, truth: Truth, level: float = 0.95) -> Interval | None:
    """Relative bias of an inverse-variance weighted mean: sharper, informational, not the gate.

    g_k = sum_p w x_k / sum_p w with w = L(r) / (s_r^2 + floor), weights from the truth alone, the
    floor being the median pixel variance. Pixels that see a light have no weight. None if that
    leaves no pixel.
    """
    variance = luminance(truth.mean_variance)
    keep = ~light_pixels(truth)
    denominator = variance + float(np.median(variance))
    weight = np.where(keep & (denominator > 0.0), luminance(truth.mean), 0.0)
    weight = np.divide(weight, denominator, out=np.zeros_like(weight), where=denominator > 0.0)
    if weight.sum() <= 0.0:
        return None
    weight /= weight.sum()
    test = np.asarray((luminance(images) * weight).sum(axis=(1, 2)))
    reference = np.asarray((luminance(truth.batches) * weight).sum(axis=(1, 2)))
    return relative_difference(test, reference, level)
