#pragma once

#include "core/math/vec3.h"

namespace haste {

/// The film counts in integers, which may be added in any order. One unit is 2^exponent.
/// 12 bits are for the sum over a pass of at most 4,096 samples, 51 for the range of a sample.
struct FixedPoint {
    static constexpr u32 max_pass_samples = 4096;
    static constexpr int range_bits = 51;

    int exponent;

    enum Status : u32 { fits = 0, non_finite = 1, out_of_range = 2 };

    /// `value` in units, rounded stochastically: the fraction below the unit is the probability of
    /// rounding up, resolved to 2^-32. Exact integer arithmetic on the float's bits.
    HASTE_HD Status convert(float value, u32 rounding, i64& units) const {
        const u32 bits = float_bits(value);
        const u32 biased = (bits >> 23) & 0xffu;
        units = 0;
        if (biased == 0xffu) return non_finite;
        const u64 mantissa = (bits & 0x7fffffu) | (biased ? 0x800000u : 0u);
        if (mantissa == 0) return fits;
        if (bits >> 31) return out_of_range;
        const int shift = int(biased ? biased : 1u) - 150 - exponent;
        if (shift >= 0) {
            if (shift > range_bits - 24) return out_of_range;
            units = i64(mantissa << shift);
        } else if (shift > -56) {
            units = i64((((mantissa << 32) >> -shift) + rounding) >> 32);
        } else {
            // Below 2^-32 of a unit: the chance of rounding up is under the generator's resolution.
            units = 0;
        }
        return fits;
    }
};

}  // namespace haste
