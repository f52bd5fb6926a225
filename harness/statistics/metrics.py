"""Image error metrics. Images are [height, width, 3] linear radiance, stacks [count, h, w, 3].

The truth is known only through independent batches, so that its own noise enters every squared
error. It is estimated from the spread of the batches and taken out again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.statistics.intervals import Interval, t_interval

Image = NDArray[np.float64]

RELATIVE_EPSILON = 1e-2
"""epsilon of relMSE, in units of the squared mean luminance of the truth."""

LUMINANCE = np.array([0.212671, 0.715160, 0.072169])
"""Luminance of linear Rec. 709 RGB (ITU-R BT.709), the constants of Mitsuba and pbrt."""


def luminance(image: Image) -> Image:
    """Luminance of the last axis: [..., 3] -> [...]."""
    return image @ LUMINANCE


@dataclass(frozen=True, slots=True)
class Truth:
    """A reference image known through R independent batches."""

    batches: Image
    """[R, h, w, 3]"""
    mean: Image
    """[h, w, 3]"""
    mean_variance: Image
    """[h, w, 3], the variance of `mean`: s_r^2 / R"""
    epsilon: float
    """added to the squared truth in the denominator of relMSE"""

    @property
    def weight(self) -> Image:
        """1 / (r^2 + epsilon), the weight of a squared error in relMSE; [h, w, 3]."""
        return 1.0 / (self.mean**2 + self.epsilon)

    @property
    def relative_noise(self) -> float:
        """The relMSE that a perfect image would show against this truth."""
        return float(np.mean(self.weight * self.mean_variance))


def make_truth(batches: NDArray[np.floating]) -> Truth:
    """Mean and variance of the mean of truth batches [R, h, w, 3]; raises ValueError if R < 2.

    A black truth has no scale of its own: epsilon is then 1, which makes relMSE the plain MSE.
    """
    stack = np.asarray(batches, dtype=np.float64)
    if stack.ndim != 4 or stack.shape[-1] != 3 or stack.shape[0] < 2:
        raise ValueError(f"a truth needs at least 2 batches [R, h, w, 3], got {stack.shape}")
    mean = stack.mean(axis=0)
    mean_variance = stack.var(axis=0, ddof=1) / stack.shape[0]
    scale = float(np.mean(luminance(mean))) ** 2
    return Truth(stack, mean, mean_variance, RELATIVE_EPSILON * scale if scale > 0.0 else 1.0)


def mse(images: Image, truth: Truth) -> NDArray[np.float64]:
    """Mean squared error of each image [K, h, w, 3] with the truth's noise removed: [K].

    Celarek et al. 2019, Quantifying the Error of Light Transport Algorithms, section 3, less
    mean_p s_r^2 / R. May be negative for an image as good as the truth.
    """
    errors = (images - truth.mean) ** 2 - truth.mean_variance
    return np.asarray(errors.mean(axis=(1, 2, 3)))


def relmse(images: Image, truth: Truth) -> NDArray[np.float64]:
    """Relative mean squared error of each image [K, h, w, 3], truth noise removed: [K].

    mean_p ((x - r)^2 - s_r^2 / R) / (r^2 + epsilon), Rousselle et al. 2011, equation 4, with
    epsilon = 1e-2 times the squared mean luminance of the truth instead of an absolute one. The
    weight is taken at the noisy truth, which errs by the order of s_r^2 / (R r^2).
    """
    errors = (images - truth.mean) ** 2 - truth.mean_variance
    return np.asarray((truth.weight * errors).mean(axis=(1, 2, 3)))


def smape(images: Image, truth: Truth) -> NDArray[np.float64]:
    """Symmetric mean absolute relative error of each image [K, h, w, 3]: [K], in [0, 2].

    mean_p 2 |x - r| / (|x| + |r|), Armstrong 1985; 0 / 0 counts as 0. Robust against outliers,
    but noise biases it: the truth's noise is not removed.
    """
    total = np.abs(images) + np.abs(truth.mean)
    ratio = np.divide(
        2.0 * np.abs(images - truth.mean), total, out=np.zeros_like(total), where=total > 0.0
    )
    return np.asarray(ratio.mean(axis=(1, 2, 3)))


@dataclass(frozen=True, slots=True)
class Split:
    """Bias and variance of an estimator known through K images and a noisy truth."""

    variance: Interval
    """mean variance of a single image"""
    bias_squared: float
    """unbiased, so that it may be negative"""
    bias_squared_error: float
    """standard error of `bias_squared`, by the jackknife over images and over the truth's batches:
    too large, by up to a factor of 2, where there is no bias (the jackknife of a degenerate
    U-statistic)"""
    variance_by_image: NDArray[np.float64]
    """[K], squared deviations from the mean image; their mean is the variance"""


def split_error(images: Image, truth: Truth, *, relative: bool, level: float = 0.95) -> Split:
    """Bias squared and variance of images [K, h, w, 3]; raises ValueError if K < 2.

    Var = mean_p w s_x^2 and Bias^2 = mean_p w ((xbar - rbar)^2 - s_x^2 / K - s_r^2 / R), so that
    E[MSE] = Var + Bias^2 after removal of the truth's noise (Celarek et al. 2019; Mueller 2016
    subtracts both variances likewise). w is 1, or that of relMSE where `relative`.
    """
    count = images.shape[0]
    if count < 2:
        raise ValueError("the split of an error into bias and variance needs at least 2 images")
    weight = truth.weight if relative else np.ones_like(truth.mean)
    mean = images.mean(axis=0)
    deviations = np.array([np.mean(weight * (image - mean) ** 2) for image in images])
    by_image = deviations * (count / (count - 1))
    variance = by_image.mean()
    noise = float(np.mean(weight * truth.mean_variance))
    bias = float(np.mean(weight * (mean - truth.mean) ** 2)) - variance / count - noise
    own = jackknife_squares(images, mean, deviations, truth.mean, weight)
    batches = truth.batches
    spread = np.array([np.mean(weight * (batch - truth.mean) ** 2) for batch in batches])
    reference = jackknife_squares(batches, truth.mean, spread, mean, weight)
    error = float(np.sqrt(own + reference))
    return Split(t_interval(by_image, level), bias, error, by_image)


def jackknife_squares(
    stack: Image, mean: Image, deviations: NDArray[np.float64], other: Image, weight: Image
) -> float:
    """Squared standard error that the noise of one side brings into a squared bias.

    Jackknife (Efron and Stein 1981, The Jackknife Estimate of Variance) of mean_p w ((mean -
    other)^2 - s^2 / n) over the n images of `stack`, whose weighted squared deviations from their
    mean are `deviations` [n]. NaN for two images that differ: each alone has no variance.
    """
    count = stack.shape[0]
    if count < 3:
        return 0.0 if deviations.sum() == 0.0 else float("nan")
    left_out = np.empty(count)
    for index in range(count):
        rest = (count * mean - stack[index]) / (count - 1)
        # Leaving image i out changes sum_k (x_k - mean)^2 by count / (count - 1) (x_i - mean)^2.
        square = deviations.sum() - deviations[index] * count / (count - 1)
        noise = square / (count - 2) / (count - 1)
        left_out[index] = float(np.mean(weight * (rest - other) ** 2)) - noise
    return float((count - 1) / count * np.sum((left_out - left_out.mean()) ** 2))


@dataclass(frozen=True, slots=True)
class Defects:
    """Pixels (not channels) that no renderer may produce."""

    non_finite: int
    negative: int
    pixels: int

    @property
    def any(self) -> bool:
        """True if one pixel is not finite or negative."""
        return self.non_finite + self.negative > 0


def count_defects(images: NDArray[np.floating]) -> Defects:
    """Count pixels with a NaN, infinite or negative channel in [..., 3]."""
    finite = np.isfinite(images)
    with np.errstate(invalid="ignore"):
        negative = (images < 0.0) & finite
    return Defects(
        int((~finite).any(axis=-1).sum()),
        int(negative.any(axis=-1).sum()),
        int(np.prod(images.shape[:-1])),
    )
