"""What turning a knob changes, from pairs of images of the same seeds.

Images x_k after the turn and e_k before it share their random numbers, so that most noise is the
same in both and their difference d_k = c x_k - e_k shows a bias that lies far below either's noise.
Every product of two images is taken over different seeds j and k, which leaves out the noise that
an image has in common with itself and with its partner. That holds as well where the numbers are
not shared; then nothing is gained.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.statistics.estimate import Estimate, log_ratio_of_means
from harness.statistics.intervals import Interval
from harness.statistics.metrics import Image, luminance


def products(first: Image, second: Image, weight: Image) -> NDArray[np.float64]:
    """mean_p w x_j y_k of all pairs of images of two stacks [K, h, w, 3]: [K, K]."""
    count = first.shape[0]
    left = (first * weight).reshape(count, -1)
    return np.asarray(left @ second.reshape(count, -1).T / weight.size)


def mean_of_pairs(table: NDArray[np.float64]) -> float:
    """Mean of a table [K, K] off its diagonal: the U-statistic of the products of two images."""
    count = table.shape[0]
    return float((table.sum() - np.trace(table)) / (count * (count - 1)))


def squared_difference(images: Image, exact: Image, weight: Image, scale: float = 1.0) -> Estimate:
    """Bias^2 = mean_p w (c E[x] - E[e])^2 from pairs of images [K, h, w, 3]; may be negative.

    The U-statistic sum_{j != k} mean_p w d_j d_k / (K (K - 1)) is unbiased (Hoeffding 1948, A Class
    of Statistics with Asymptotically Normal Distribution); its error is the jackknife's over the
    pairs (Efron and Stein 1981), too large by up to a factor of two where there is no difference.
    Raises ValueError for fewer than three pairs or stacks of different sizes.
    """
    count = images.shape[0]
    if count < 3 or exact.shape != images.shape:
        raise ValueError(f"3 pairs are needed, got {images.shape} and {exact.shape}")
    difference = scale * images - exact
    table = products(difference, difference, weight)
    own = np.diag(table)
    # Without pair i: its row and its column leave the sum.
    rest = (table.sum() - own.sum() - 2.0 * (table.sum(axis=1) - own)) / ((count - 1) * (count - 2))
    error = float(np.sqrt((count - 1) / count * np.sum((rest - rest.mean()) ** 2)))
    return Estimate(mean_of_pairs(table), error, float(count - 1), count)


def paired_scale(images: Image, exact: Image, weight: Image) -> float:
    """The factor c that brings images [K, h, w, 3] closest to those of the exact variant.

    c = sum_{j != k} w x_j e_k / sum_{j != k} w x_j x_k, the `least_squares_scale` of
    `harness.statistics.trade` for pairs. 1 where the images are black.
    """
    square = mean_of_pairs(products(images, images, weight))
    return mean_of_pairs(products(images, exact, weight)) / square if square > 0.0 else 1.0


def paired_relative_bias(images: Image, exact: Image, scale: float = 1.0) -> Interval:
    """(mean luminance of c x - of e) / of e, from pairs [K, h, w, 3]; c is taken as known."""
    first, second = (np.asarray(luminance(stack).mean(axis=(1, 2))) for stack in (images, exact))
    found = log_ratio_of_means(scale * first, second, paired=True).ratio()
    return Interval(found.value - 1.0, found.lower - 1.0, found.upper - 1.0, found.n)
