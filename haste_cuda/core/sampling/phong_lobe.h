#pragma once

#include "core/math/elementary.h"
#include "core/math/trigonometry.h"
#include "core/math/vec3.h"

namespace haste {

/// max(0, cos)^exponent for the angle between two unit vectors, through 1 - cos = |a - b|^2 / 2,
/// which keeps its digits near the peak of a sharp lobe, where the cosine has lost them.
template <class Real>
HASTE_HD Real power_of_cosine(const Vec3<Real>& a, const Vec3<Real>& b, Real exponent) {
    const Real one_minus_cosine = Real(0.5) * length_squared(a - b);
    if (one_minus_cosine >= Real(1)) return Real(0);
    return exponential(exponent * logarithm_of_one_plus(-one_minus_cosine));
}

/// Density (exponent + 1) / (2 pi) cos^exponent about +z. The sine by expm1, which keeps its digits
/// for sharp lobes; u = 0 gives the axis.
template <class Real>
HASTE_HD Vec3<Real> phong_lobe(Real u, Real v, Real exponent) {
    const Real log_cosine = logarithm_of_one_plus(-u) / (exponent + Real(1));
    const Real radius = safe_square_root(-exponential_minus_one(Real(2) * log_cosine));
    const SinCos<Real> phi = sin_cos_of_turn(v);
    return {radius * phi.cosine, radius * phi.sine, exponential(log_cosine)};
}

}  // namespace haste
