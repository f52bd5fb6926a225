"""Single-precision functions against float64 on the same float32 inputs."""

from __future__ import annotations

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("active")

SEED = 20101


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=1, keepdims=True)


@pytest.mark.parametrize("exponent", [1.0, 30.0, 1e3, 1e6])
def test_power_of_cosine_keeps_its_digits_inside_a_sharp_lobe(exponent: float):
    import mitsuba as mi

    from reference.mitsuba.numeric import power_of_cosine

    generator = np.random.default_rng(SEED)
    a = unit(generator.standard_normal((20_000, 3))).astype(np.float32)
    spread = generator.uniform(0.0, 3.0, (20_000, 1)) / np.sqrt(exponent)
    b = unit(a + spread * unit(generator.standard_normal((20_000, 3)))).astype(np.float32)
    result = np.asarray(
        power_of_cosine(mi.Vector3f(a.T), mi.Vector3f(b.T), mi.Float(exponent)), dtype=np.float64
    )
    versine = 0.5 * np.sum((a.astype(np.float64) - b) ** 2, axis=1)
    result, versine = result[versine < 0.5], versine[versine < 0.5]
    logarithm = exponent * np.log1p(-versine)
    # Each rounding of the versine and of its logarithm counts |logarithm| times in the result.
    error = np.abs(result / np.exp(logarithm) - 1.0) / (1.0 + np.abs(logarithm))
    assert error.max() < 1e-6, f"exponent {exponent}: relative error {error.max():.2e}"


def test_the_plain_power_would_fail_that_test():
    exponent = np.float32(1e6)
    angle = np.float64(1e-3)
    cosine = np.float32(np.cos(angle))
    expected = np.exp(1e6 * np.log(np.cos(angle)))
    assert abs(np.float64(cosine**exponent) / expected - 1.0) > 1e-2


@pytest.mark.parametrize("exponent", [1.0, 1e3, 1e6])
def test_sampled_sine_keeps_its_digits_near_the_axis(exponent: float):
    import mitsuba as mi

    from reference.mitsuba.numeric import sample_power_of_cosine

    u = np.random.default_rng(SEED).random(20_000, dtype=np.float32)
    u[:3] = [0.0, 2.0**-24, 1.0 - 2.0**-24]
    direction = sample_power_of_cosine(
        mi.Point2f(mi.Float(u), mi.Float(np.zeros_like(u))), mi.Float(exponent)
    )
    sine = np.asarray(direction.x, dtype=np.float64)
    log_cosine = np.log1p(-u.astype(np.float64)) / (exponent + 1.0)
    expected = np.sqrt(-np.expm1(2.0 * log_cosine))
    error = np.abs(sine - expected) / np.maximum(expected, 1e-30)
    assert error.max() < 1e-6, f"exponent {exponent}: relative error {error.max():.2e}"
    assert np.all(np.asarray(direction.z) >= 0.0)
