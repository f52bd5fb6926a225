#pragma once

#include "core/math/numeric.h"

namespace haste {

/// Sine and cosine of one angle.
template <class Real>
struct SinCos {
    Real sine, cosine;
};

/// sin(2 pi u) and cos(2 pi u) for u in [0, 1): exact reduction to an eighth of a turn, then the
/// Taylor series, truncated below half an ulp. No table and no argument reduction in memory, which
/// the platform's sine needs on a GPU; equal bits wherever the four operations round alike.
template <class Real>
HASTE_HD SinCos<Real> sin_cos_of_turn(Real u) {
    const int octant = int(u * Real(8));
    const int quarter = (octant + 1) >> 1;
    const Real angle = (u - Real(quarter) * Real(0.25)) * (Real(2) * Numeric<Real>::pi);
    const Real x = angle * angle;
    constexpr int terms = sizeof(Real) == sizeof(float) ? 5 : 9;
    Real sine = Real(1);
    Real cosine = Real(1);
    for (int k = terms; k >= 1; --k) {
        sine = Real(1) - sine * x * (Real(1) / Real((2 * k) * (2 * k + 1)));
        cosine = Real(1) - cosine * x * (Real(1) / Real((2 * k - 1) * (2 * k)));
    }
    sine = sine * angle;
    switch (quarter & 3) {
        case 0:
            return {sine, cosine};
        case 1:
            return {cosine, -sine};
        case 2:
            return {-sine, -cosine};
        default:
            return {-cosine, sine};
    }
}

}  // namespace haste
