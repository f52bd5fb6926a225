#pragma once

#include "core/math/numeric.h"

namespace haste {

/// Elementary functions of sums, products, quotients and fma alone, which all platforms round
/// alike: equal bits on processor and GPU, where those of the platforms' libraries differ. Each is
/// within 2 ulp on the arguments that the models have. In single precision there are no quotients,
/// each of which takes a GPU as long as a polynomial.
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

/// 1 / k!
template <class Real>
HASTE_HD constexpr Real inverse_factorial(int k) {
    double product = 1;
    for (int i = 2; i <= k; ++i) product *= i;
    return Real(1 / product);
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
        constexpr int terms = ElementaryConstants<Real>::exponential_terms;
        Real sum = inverse_factorial<Real>(terms);
        for (int k = terms - 1; k >= 1; --k) {
            sum = fma(sum, r, inverse_factorial<Real>(k));
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

/// ln(1 + f) - f for f from sqrt(1/2) - 1 to sqrt(2) - 1.
HASTE_HD inline float logarithm_rest(float f) {
    // The polynomial of Moshier's Cephes library, logf.
    constexpr float coefficients[] = {0.070376836292f, -0.11514610310f, 0.11676998740f,
                                      -0.12420140846f, 0.14249322787f,  -0.16668057665f,
                                      0.20000714765f,  -0.24999993993f, 0.33333331174f};
    const float squared = f * f;
    float sum = coefficients[0];
    for (int k = 1; k < 9; ++k) {
        sum = fma(sum, f, coefficients[k]);
    }
    return fma(squared * f, sum, -0.5f * squared);
}

HASTE_HD inline double logarithm_rest(double f) {
    // ln(1 + f) = 2 artanh(s) with s = f / (2 + f), and 2 s = f - s f.
    const double s = f / (2.0 + f);
    const double z = s * s;
    double sum = 0.0;
    for (int k = ElementaryConstants<double>::logarithm_terms; k >= 1; --k) {
        sum = fma(sum, z, 1.0 / (2 * k + 1));
    }
    return fma(2.0 * s, z * sum, -s * f);
}

/// ln(1 + y), for y from -1 to 1.
template <class Real>
HASTE_HD Real logarithm_of_one_plus(Real y) {
    using C = ElementaryConstants<Real>;
    if (!(y > Real(-1))) return -Numeric<Real>::infinity;
    const Real x = Real(1) + y;
    const int n = exponent_of(x);
    const Real scale = power_of_two(-n, y);
    const Real f = x * scale - Real(1);
    // What x lacks is less than half of its last bit: 1 - f + f^2 is enough of 1 / (1 + f).
    const Real lost = (y - (x - Real(1))) * scale;
    const Real rest = fma(lost, fma(f, f - Real(1), Real(1)), logarithm_rest(f));
    return fma(Real(n), C::ln2_high, fma(Real(n), C::ln2_low, rest) + f);
}

/// The cube root of a number that is not negative, by Newton's iteration for the reciprocal root,
/// which has no quotient.
template <class Real>
HASTE_HD Real cube_root(Real w) {
    if (w == Real(0)) return w;
    constexpr Real third = Real(1) / Real(3);
    // A third of the bits is a third of the logarithm, within 4 %.
    Real z = Real(bits_float(0x54a21d2au - float_bits(float(w)) / 3u));
    constexpr int iterations = sizeof(Real) == sizeof(float) ? 3 : 4;
    for (int i = 0; i < iterations; ++i) {
        z = fma(z * third, fma(-w * z, z * z, Real(1)), z);
    }
    const Real y = w * z * z;
    return fma(fma(y * y, -y, w) * third, z * z, y);
}

}  // namespace haste
