"""The exposures of HDR-FLIP, pinned by the truth: the same for every tracer of a panel.

Andersson et al. 2021, Visualizing Errors in Rendered High Dynamic Range Images, section 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from harness.statistics.metrics import Image

ACES = (0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14)
"""Narkowicz's fit of the ACES tone curve with exposure 0.6, as FLIP has it:
(a x^2 + b x + c) / (d x^2 + e x + f)."""
BRIGHT = 0.85
"""Tone-mapped value to which the exposures bring the largest and the median luminance."""
FLIP_LUMINANCE = np.array([2613072.0, 8788810.0, 887015.0]) / 12288897.0
"""Luminance of linear Rec. 709 RGB, the constants of FLIP."""


@dataclass(frozen=True, slots=True)
class Exposures:
    """Stops at which images are compared: `count` of them, evenly from `start` to `stop`."""

    start: float
    stop: float
    count: int


def pin_exposures(truth: Image) -> Exposures:
    """Exposures for a truth [h, w, 3] in stops of the radiance itself; a black one gets 0.

    The last brings the median luminance to BRIGHT. Where it is black, that of the lit pixels is
    taken, for which the paper has no answer.
    """
    light = truth @ FLIP_LUMINANCE
    lit = light[light > 0.0]
    if lit.size == 0:
        return Exposures(0.0, 0.0, 2)
    median = float(np.median(light))
    a, b, c, d, e, f = ACES
    roots = np.roots([a - BRIGHT * d, b - BRIGHT * e, c - BRIGHT * f])
    bright = float(roots.max())
    start = float(np.log2(bright / lit.max()))
    stop = float(np.log2(bright / (median if median > 0.0 else np.median(lit))))
    return Exposures(start, stop, max(2, int(np.ceil(stop - start))))
