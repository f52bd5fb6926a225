#pragma once

#include "core/config.h"

namespace haste {

/// Constants of a floating-point type and the rounding-error bound built on them.
/// The only place of the core where an absolute or relative tolerance may be written.
template <class Real>
struct Numeric;

template <>
struct Numeric<float> {
    /// Half an ulp of one.
    static constexpr float unit_roundoff = 0x1p-24f;
    /// The least component of a direction that slabs are entered by, in units of the largest.
    static constexpr float least_slope = 0x1p-32f;
    /// What a distance that is divided by is taken for where it is 0.
    static constexpr float least_distance = 0x1p-100f;
    static constexpr float infinity = __builtin_bit_cast(float, 0x7f800000u);
    static constexpr float pi = 3.14159265358979323846f;
};

template <>
struct Numeric<double> {
    static constexpr double unit_roundoff = 0x1p-53;
    static constexpr double least_slope = 0x1p-64;
    static constexpr double infinity = __builtin_bit_cast(double, 0x7ff0000000000000ull);
    static constexpr double pi = 3.14159265358979323846;
};

/// gamma(n) = n u / (1 - n u): the relative error that n rounded operations can pile up
/// (Higham, Accuracy and Stability of Numerical Algorithms, section 3.1).
template <class Real>
HASTE_HD constexpr Real gamma_bound(int n) {
    const Real nu = Real(n) * Numeric<Real>::unit_roundoff;
    return nu / (Real(1) - nu);
}

/// `a < b ? a : b`: returns b where a is NaN. The slab test relies on that order.
template <class Real>
HASTE_HD constexpr Real minimum(Real a, Real b) {
    return a < b ? a : b;
}

/// `a > b ? a : b`: returns b where a is NaN.
template <class Real>
HASTE_HD constexpr Real maximum(Real a, Real b) {
    return a > b ? a : b;
}

template <class Real>
HASTE_HD constexpr Real absolute(Real a) {
    return a < Real(0) ? -a : a;
}

/// Square root that takes the small negative results of rounding for zero.
template <class Real>
HASTE_HD Real safe_square_root(Real a) {
    return square_root(maximum(a, Real(0)));
}

/// a b - c d within 1.5 ulp by Kahan's compensation, so its sign is exact and it is zero only
/// where the exact value is (Jeannerod, Louvet and Muller, Further analysis of Kahan's algorithm).
template <class Real>
HASTE_HD Real difference_of_products(Real a, Real b, Real c, Real d) {
    const Real cd = c * d;
    const Real error = fma(-c, d, cd);
    return fma(a, b, -cd) + error;
}

}  // namespace haste
