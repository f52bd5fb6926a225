#pragma once

#include "core/math/numeric.h"

namespace haste {

/// Elementary functions of sums, products, quotients and fma alone, which all platforms round
/// alike: equal bits on processor and GPU, where those of the platforms' libraries differ. Each is
/// within 2 ulp on the arguments that the models have.
/// Reductions and series as in Muller, Elementary Functions, third edition, 2016, sections 11.1
/// to 11.3; ln 2 in two parts as in Cody and Waite, Software Manual for the Elementary Functions,
/// 1980.
template <class Real>
struct ElementaryConstants;

template <>
struct ElementaryConstants<float> {
    static constexpr float log2_of_e = 1.44269504088896340736f;
    static constexpr float ln2_high = 0.693359375f;  ///< nine bits: times an exponent exact
    static constexpr float ln2_low = -2.12194440054690582768e-4f;
    static constexpr int exponential_terms = 7;
    static constexpr int logarithm_terms = 5;
    static constexpr float least_exponent = -104.0f;  ///< whose exponential is half of the least
    static constexpr float greatest_exponent = 89.0f;
};

template <>
struct ElementaryConstants<double> {
    static constexpr double log2_of_e = 1.44269504088896340736;
    static constexpr double ln2_high = 0.693145751953125;  ///< twenty bits
    static constexpr double ln2_low = 1.42860682030941723212e-6;
    static constexpr int exponential_terms = 14;
    static constexpr int logarithm_terms = 11;
    static constexpr double least_exponent = -746.0;
    static constexpr double greatest_exponent = 710.0;
};

/// 2^n for n of a normal number.
HASTE_HD inline float power_of_two(int n, float) { return bits_float(u32(n + 127) << 23); }
HASTE_HD inline double power_of_two(int n, double) { return bits_double(u64(n + 1023) << 52); }

/// The exponent n of a positive normal number x = m 2^n with m from sqrt(1/2) to sqrt(2), nearly.
HASTE_HD inline int exponent_of(float x) { return int((float_bits(x) + 0x4afb0du) >> 23) - 127; }
HASTE_HD inline int exponent_of(double x) {
    return int((double_bits(x) + 0x95f619980c433ull) >> 52) - 1023;
}

/// x = n ln 2 + r with |r| <= ln(2) / 2, nearly.
template <class Real>
struct ReducedExponent {
    int n;
    Real r;

    HASTE_HD explicit ReducedExponent(Real x) {
        using C = ElementaryConstants<Real>;
        const Real scaled = x * C::log2_of_e;
        n = int(scaled + (scaled < Real(0) ? Real(-0.5) : Real(0.5)));
        r = fma(Real(-n), C::ln2_low, fma(Real(-n), C::ln2_high, x));
    }

    /// e^r - 1.
    HASTE_HD Real exponential_minus_one() const {
        Real sum = Real(1);
        for (int k = ElementaryConstants<Real>::exponential_terms; k >= 2; --k) {
            sum = fma(sum, r * (Real(1) / Real(k)), Real(1));
        }
        return r * sum;
    }
};

/// e^x.
template <class Real>
HASTE_HD Real exponential(Real x) {
    using C = ElementaryConstants<Real>;
    if (x < C::least_exponent) return Real(0);
    if (x > C::greatest_exponent) return Numeric<Real>::infinity;
    const ReducedExponent<Real> reduced(x);
    const Real mantissa = Real(1) + reduced.exponential_minus_one();
    // In two steps, for 2^n alone may leave the range.
    const int half = reduced.n / 2;
    return mantissa * power_of_two(half, x) * power_of_two(reduced.n - half, x);
}

/// e^x - 1, for x <= 0.
template <class Real>
HASTE_HD Real exponential_minus_one(Real x) {
    constexpr Real vanishing = Real(-64);
    if (x < vanishing) return Real(-1);
    const ReducedExponent<Real> reduced(x);
    const Real scale = power_of_two(reduced.n, x);
    return fma(scale, reduced.exponential_minus_one(), scale - Real(1));
}

/// ln(1 + y), for y from -1 to 1.
template <class Real>
HASTE_HD Real logarithm_of_one_plus(Real y) {
    using C = ElementaryConstants<Real>;
    if (!(y > Real(-1))) return -Numeric<Real>::infinity;
    const Real x = Real(1) + y;
    const Real lost = y - (x - Real(1));
    const int n = exponent_of(x);
    const Real f = x * power_of_two(-n, y) - Real(1);
    // ln(1 + f) = 2 artanh(f / (2 + f)).
    const Real s = f / (Real(2) + f);
    const Real z = s * s;
    Real sum = Real(0);
    for (int k = C::logarithm_terms; k >= 1; --k) {
        sum = fma(sum, z, Real(1) / Real(2 * k + 1));
    }
    // 2 s = f - s f, of which f is exact.
    const Real rest = fma(Real(2) * s, z * sum, -s * f) + lost / x;
    return fma(Real(n), C::ln2_high, fma(Real(n), C::ln2_low, rest) + f);
}

/// The cube root of a number that is not negative, by Halley's iteration.
template <class Real>
HASTE_HD Real cube_root(Real w) {
    if (w == Real(0)) return w;
    // A third of the bits is a third of the logarithm, within 4 %.
    Real y = Real(bits_float(float_bits(float(w)) / 3u + 0x2a5137a0u));
    constexpr int iterations = sizeof(Real) == sizeof(float) ? 2 : 3;
    for (int i = 0; i < iterations; ++i) {
        const Real cube = y * y * y;
        y = y - y * ((cube - w) / (cube + cube + w));
    }
    return y;
}

}  // namespace haste
