"""Images as text: half floats, their bytes sorted by significance, deflated, in base64."""

from __future__ import annotations

import base64
import zlib

import numpy as np
from numpy.typing import NDArray

from harness.viewer.panels import Moments

LARGEST = float(np.finfo(np.float16).max)
DIMMEST = 2.0**-6
"""An image whose largest value is below it is scaled, or a hundredth of it would be subnormal."""


def exponent_of(moments: Moments) -> int:
    """Power of two that is taken out of an image for half floats to hold it: mostly 0."""
    values = np.abs(moments.mean[np.isfinite(moments.mean)])
    top = float(values.max()) if values.size else 0.0
    if top == 0.0 or DIMMEST <= top <= LARGEST:
        return 0
    return int(np.floor(np.log2(top))) - 14


def to_halves(moments: Moments) -> NDArray[np.float16]:
    """Planes red, green, blue and sigma over 2^exponent: [4, h, w]."""
    planes = np.concatenate([np.moveaxis(moments.mean, -1, 0), moments.sigma[None]])
    scaled = np.ldexp(planes, -exponent_of(moments))
    # A single fabulous sigma beside a mean in range would be infinite.
    scaled[3] = np.minimum(scaled[3], np.float32(LARGEST))
    return scaled.astype(np.float16)


def encode(halves: NDArray[np.float16]) -> str:
    """Low bytes of all values, then high bytes, deflated (RFC 1950), in base64.

    Signs and exponents beside each other deflate well, the noise of the low bytes hardly.
    """
    values = np.ascontiguousarray(halves, dtype="<f2").reshape(-1)
    sorted_bytes = values.view(np.uint8).reshape(-1, 2).T.tobytes()
    return base64.b64encode(zlib.compress(sorted_bytes, 9)).decode()
