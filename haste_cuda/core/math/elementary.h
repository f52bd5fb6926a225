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
    static constexpr float rounder = 0x1.8p23f;       ///< a sum with it has no fraction
    static constexpr float least_exponent = -104.0f;  ///< whose exponential is half of the least
    static constexpr float greatest_exponent = 89.0f;
};

template <>
struct ElementaryConstants<double> {
    static constexpr double log2_of_e = 1.44269504088896340736;
    static constexpr double ln2_high = 0.693145751953125;  ///< twenty bits
    static constexpr double ln2_low = 1.42860682030941723212e-6;
    static constexpr double rounder = 0x1.8p52;
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

/// The integer that was added to `rounder`.
HASTE_HD inline int integer_of(float sum) { return int(float_bits(sum) - 0x4b400000u); }
HASTE_HD inline int integer_of(double sum) { return int(double_bits(sum) - 0x4338000000000000ull); }

/// (e^r - 1 - r) / r^2 for |r| <= ln(2) / 2, nearly: the coefficients of expf in Cephes (Moshier,
/// Methods and Programs for Mathematical Functions, 1989).
HASTE_HD inline float exponential_rest(float r) {
    float sum = 1.9875691500e-4f;
    sum = fma(sum, r, 1.3981999507e-3f);
    sum = fma(sum, r, 8.3334519073e-3f);
    sum = fma(sum, r, 4.1665795894e-2f);
    sum = fma(sum, r, 1.6666665459e-1f);
    return fma(sum, r, 5.0000001201e-1f);
}
/// The same by Taylor's series.
HASTE_HD inline double exponential_rest(double r) {
    constexpr int terms = 14;
    double sum = 1.0;
    for (int k = terms; k >= 3; --k) sum = fma(sum, r * (1.0 / double(k)), 1.0);
    return 0.5 * sum;
}

/// (ln(1 + f) - f + f^2 / 2) / f^3 for 1 + f from sqrt(1/2) to sqrt(2): the coefficients of logf in
/// Cephes.
HASTE_HD inline float logarithm_rest(float f) {
    float sum = 7.0376836292e-2f;
    sum = fma(sum, f, -1.1514610310e-1f);
    sum = fma(sum, f, 1.1676998740e-1f);
    sum = fma(sum, f, -1.2420140846e-1f);
    sum = fma(sum, f, 1.4249322787e-1f);
    sum = fma(sum, f, -1.6668057665e-1f);
    sum = fma(sum, f, 2.0000714765e-1f);
    sum = fma(sum, f, -2.4999993993e-1f);
    return fma(sum, f, 3.3333331174e-1f);
}

/// x = n ln 2 + r with |r| <= ln(2) / 2, nearly. What is no number gives an r that is none.
template <class Real>
struct ReducedExponent {
    int n;
    Real r;

    HASTE_HD explicit ReducedExponent(Real x) {
        using C = ElementaryConstants<Real>;
        const Real sum = fma(x, C::log2_of_e, C::rounder);
        const Real whole = sum - C::rounder;
        n = integer_of(sum);
        r = fma(-whole, C::ln2_low, fma(-whole, C::ln2_high, x));
    }

    /// e^r - 1.
    HASTE_HD Real exponential_minus_one() const { return fma(r * r, exponential_rest(r), r); }
};

/// e^x.
template <class Real>
HASTE_HD Real exponential(Real x) {
    using C = ElementaryConstants<Real>;
    // In this order NaN stays what it is.
    const Real clamped = minimum(C::greatest_exponent, maximum(C::least_exponent, x));
    const ReducedExponent<Real> reduced(clamped);
    const Real mantissa = Real(1) + reduced.exponential_minus_one();
    // In two steps, for 2^n alone may leave the range.
    const int half = reduced.n / 2;
    return mantissa * power_of_two(half, x) * power_of_two(reduced.n - half, x);
}

/// e^x - 1, for x <= 0.
template <class Real>
HASTE_HD Real exponential_minus_one(Real x) {
    constexpr Real vanishing = Real(-64);
    const ReducedExponent<Real> reduced(maximum(vanishing, x));
    const Real scale = power_of_two(reduced.n, x);
    return fma(scale, reduced.exponential_minus_one(), scale - Real(1));
}

/// ln(1 + f) - f, plus `more`, by the polynomial.
HASTE_HD inline float logarithm_beyond(float f, float more) {
    const float square = f * f;
    return fma(f * square, logarithm_rest(f), fma(-0.5f, square, more));
}
/// The same by 2 artanh(s) = f - s f + 2 s (s^2 / 3 + s^4 / 5 + ...), of which f is exact.
HASTE_HD inline double logarithm_beyond(double f, double more) {
    constexpr int terms = 11;
    const double s = f / (2.0 + f);
    const double square = s * s;
    double sum = 0.0;
    for (int k = terms; k >= 1; --k) sum = fma(sum, square, 1.0 / double(2 * k + 1));
    return fma(2.0 * s, square * sum, -s * f) + more;
}

/// ln(1 + y), for y from -1 to 1.
template <class Real>
HASTE_HD Real logarithm_of_one_plus(Real y) {
    using C = ElementaryConstants<Real>;
    if (!(y > Real(-1))) return -Numeric<Real>::infinity;
    const Real x = Real(1) + y;
    const Real lost = y - (x - Real(1));
    const int n = exponent_of(x);
    const Real scale = power_of_two(-n, y);
    const Real f = fma(x, scale, Real(-1));
    // What the sum has lost, over it: 1 / (1 + f) is 1 - f + f^2, as near as a rounding needs.
    const Real rest = lost * scale * fma(f, f - Real(1), Real(1));
    const Real low = logarithm_beyond(f, fma(Real(n), C::ln2_low, rest));
    return fma(Real(n), C::ln2_high, low + f);
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
