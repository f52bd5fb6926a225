"""Does an image show the truth at its place? A grid off by half a pixel moves every edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.statistics.estimate import Estimate, combine, mean_of
from harness.statistics.metrics import Image, Truth, luminance


@dataclass(frozen=True, slots=True)
class Shift:
    """How far the images lie from the truth, in pixels."""

    right: Estimate
    down: Estimate


def find_shift(images: Image, truth: Truth) -> Shift | None:
    """Shift of images [K, h, w, 3] against the truth; None where the picture has no edges.

    Least squares of x - r = -(right d/dx + down d/dy) r over the pixels (Lucas and Kanade 1981, An
    Iterative Image Registration Technique, section 3), with weights from the noise of the truth.
    The estimate is linear in the image, so that its error follows from the spread over images and
    batches. The gradient is a central difference; its own noise makes the shift too small, never
    too large. Raises ValueError for fewer than two images.
    """
    if images.shape[0] < 2:
        raise ValueError("the error of a shift needs at least 2 images")
    light = luminance(truth.mean)
    if min(light.shape) < 3:
        return None
    variance = luminance(truth.mean_variance)[1:-1, 1:-1]
    down, right = (part[1:-1, 1:-1].ravel() for part in np.gradient(light))
    floor = float(np.mean(light)) ** 2 * 2.0**-16
    weight = 1.0 / (variance.ravel() + floor) if floor > 0.0 else np.zeros(right.size)
    basis = np.stack([right, down])
    normal = (basis * weight) @ basis.T
    if not np.linalg.det(normal) > 1e-6 * normal.trace() ** 2:
        return None
    solve = -np.linalg.solve(normal, basis * weight)

    def shifts(stack: Image) -> NDArray[np.float64]:
        inner = (luminance(stack) - light)[:, 1:-1, 1:-1]
        return np.asarray(inner.reshape(stack.shape[0], -1) @ solve.T)

    own, reference = shifts(images), shifts(truth.batches)
    return Shift(
        *(
            combine([(1.0, mean_of(own[:, axis])), (-1.0, mean_of(reference[:, axis]))])
            for axis in (0, 1)
        )
    )
