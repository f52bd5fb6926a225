"""Tone mapping of radiance to PNG, and colour maps of signed errors."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage

from harness.statistics.metrics import Image, Truth, luminance

EXPOSURE_PERCENTILE = 99.0
WHITE_POINT = 0.9
"""Linear display value to which the exposure brings that percentile."""

NEGATIVE = np.array([[0x05, 0x30, 0x61], [0x43, 0x93, 0xC3], [0xF7, 0xF7, 0xF7]]) / 255.0
POSITIVE = np.array([[0xF7, 0xF7, 0xF7], [0xD6, 0x60, 0x4D], [0x67, 0x00, 0x1F]]) / 255.0
"""Ends, middles and centre of ColorBrewer's RdBu (Harrower and Brewer 2003)."""


def exposure_of(truth: Image) -> float:
    """Factor that brings the 99th percentile of the lit pixels' luminance to 0.9.

    Lights and reflections of them may clip; a black image has exposure 1. truth: [h, w, 3].
    """
    light = luminance(truth)
    lit = light[light > 0.0]
    if lit.size == 0:
        return 1.0
    # A light that fills more than one pixel in a hundred must not make the scene dark.
    median, bright = np.median(lit), np.percentile(lit, EXPOSURE_PERCENTILE)
    return float(WHITE_POINT / min(bright, 6.0 * median))


def encode_srgb(linear: Image) -> NDArray[np.uint8]:
    """Linear Rec. 709 in [0, 1] to 8-bit sRGB (IEC 61966-2-1); clips, NaN becomes magenta."""
    broken = ~np.isfinite(linear).all(axis=-1)
    value = np.clip(np.nan_to_num(linear), 0.0, 1.0)
    curve = np.where(
        value <= 0.0031308, 12.92 * value, 1.055 * np.maximum(value, 1e-9) ** (1 / 2.4) - 0.055
    )
    curve[broken] = [1.0, 0.0, 1.0]
    return np.asarray(np.rint(255.0 * curve), dtype=np.uint8)


def relative_error(image: Image, truth: Truth) -> Image:
    """Signed relative error of the luminance, [h, w]: (x - r) / sqrt(r^2 + epsilon)."""
    reference = luminance(truth.mean)
    return np.asarray((luminance(image) - reference) / np.sqrt(reference**2 + truth.epsilon))


def error_range(errors: list[Image]) -> float:
    """Symmetric range of error maps: the 99.5th percentile, rounded up to 1, 2 or 5 times 10^k."""
    values = np.concatenate([np.abs(error[np.isfinite(error)]).ravel() for error in errors])
    top = float(np.percentile(values, 99.5)) if values.size else 0.0
    if top <= 1e-6:
        return 1e-6
    decade = 10.0 ** np.floor(np.log10(top))
    return float(decade * next(step for step in (1.0, 2.0, 5.0, 10.0) if top <= step * decade))


def colour_errors(error: Image, limit: float) -> NDArray[np.uint8]:
    """Blue (too dark), white, red (too bright) of an error in [-limit, limit]: [..., 3]."""
    position = np.clip(np.nan_to_num(error / limit), -1.0, 1.0)
    knots = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    table = np.concatenate([NEGATIVE, POSITIVE[1:]])
    colours = np.stack([np.interp(position, knots, table[:, c]) for c in range(3)], axis=-1)
    colours[~np.isfinite(error)] = [1.0, 0.0, 1.0]
    return np.asarray(np.rint(255.0 * colours), dtype=np.uint8)


def encode_png(pixels: NDArray[np.uint8]) -> bytes:
    """8-bit RGB [h, w, 3] as the bytes of a PNG file."""
    buffer = io.BytesIO()
    PillowImage.fromarray(pixels).save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()
