"""Single-precision functions that Dr.Jit lacks, accurate where a sharp Phong lobe needs them.

A power of a cosine loses its exponent times 2^-24 in relative accuracy when the cosine itself is
rounded, 36 % at an exponent of 10^6. The distance between the two directions keeps the digits that
the cosine loses: 1 - cos(theta) = |a - b|^2 / 2 for unit vectors.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi


def log1p(x: Any) -> Any:
    """log(1 + x) for x > -1, after Kahan: the rounding of 1 + x cancels in the quotient."""
    u = 1.0 + x
    return dr.select(u == 1.0, x, dr.log(u) * (x / (u - 1.0)))


def expm1(x: Any) -> Any:
    """exp(x) - 1 for x <= 0, after Kahan (Higham, Accuracy and Stability, section 1.14.1)."""
    u = dr.exp(x)
    small = u == 1.0
    far = u < 0.25
    quotient = (u - 1.0) * (x / dr.log(dr.select(small | far, 0.5, u)))
    return dr.select(small, x, dr.select(far, u - 1.0, quotient))


def power_of_cosine(a: Any, b: Any, exponent: Any) -> Any:
    """max(0, a . b)^exponent for unit vectors ``a`` and ``b`` and exponent > 0."""
    versine = 0.5 * dr.squared_norm(a - b)
    inside = versine < 1.0
    return dr.select(inside, dr.exp(exponent * log1p(-dr.select(inside, versine, 0.5))), 0.0)


def sample_power_of_cosine(sample: Any, exponent: Any) -> Any:
    """Direction about +z with density (exponent + 1) / (2 pi) cos(theta)^exponent.

    ``sample`` is a point of the unit square. The sine is computed from the logarithm of the cosine,
    not from the rounded cosine, which is 1 for most samples of a sharp lobe.
    """
    log_cosine = log1p(-sample.x) / (exponent + 1.0)
    cosine = dr.exp(log_cosine)
    sine = dr.safe_sqrt(-expm1(2.0 * log_cosine))
    sin_phi, cos_phi = dr.sincos(2.0 * dr.pi * sample.y)
    return mi.Vector3f(sine * cos_phi, sine * sin_phi, cosine)
