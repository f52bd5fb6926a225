"""Are images of different seeds independent? Without that no standard error means anything."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from harness.statistics.metrics import Image, luminance

LEAST_PIXELS = 64
"""Pixels that must vary; the mean of fewer products is not normal enough for a small p-value."""


@dataclass(frozen=True, slots=True)
class Correlation:
    """The two images that resemble each other most, beyond what they must."""

    first: int
    second: int
    """places in the stack"""
    value: float
    """correlation of their noise, 0 for independent images"""
    p: float
    """chance of it, one-sided, for these two images"""
    pairs: int


def strongest_correlation(images: Image) -> Correlation | None:
    """Compare the noise of every two of K images [K, h, w, 3]; None where hardly a pixel varies.

    z_k = (x_k - mean) / s of each pixel, so that none outweighs the others: a plain correlation of
    images with few bright, noisy pixels misleads. Of independent images the mean of z_k z_l is
    -1 / K, since the z of a pixel sum to 0 and their squares to K - 1. Pixels are independent (a
    box filter), and a product is at most K - 1, so that their mean over the pixels is normal with
    the error that the products show. What all images share moves their mean and is left to the
    test of tiles. Raises ValueError for fewer than three images.
    """
    count = images.shape[0]
    if count < 3:
        raise ValueError(f"a correlation of seeds needs at least 3 images, got {count}")
    light = luminance(images).reshape(count, -1)
    spread = light.std(axis=0, ddof=1)
    # A spread that is rounding of equal values counts as none.
    varies = spread > 2.0**-20 * np.abs(light).max(axis=0)
    pixels = int(varies.sum())
    if pixels < LEAST_PIXELS:
        return None
    z = (light[:, varies] - light[:, varies].mean(axis=0)) / spread[varies]
    product = z @ z.T / pixels
    variance = np.maximum(z**2 @ (z**2).T / pixels - product**2, 1e-12) / pixels
    excess = product + 1.0 / count
    rows, columns = np.triu_indices(count, 1)
    t = excess[rows, columns] / np.sqrt(variance[rows, columns])
    best = int(np.argmax(t))
    first, second = int(rows[best]), int(columns[best])
    return Correlation(
        first, second, float(excess[first, second]), float(stats.norm.sf(t[best])), int(t.size)
    )
