#pragma once

#include "core/sampling/philox.h"

namespace haste {

/// Uniform in [0, 1) from the upper 24 bits: never 1, in any precision the same number.
template <class Real>
HASTE_HD constexpr Real uniform(u32 bits) {
    return Real(bits >> 8) * Real(0x1p-24);
}

/// 32 bits for the film's rounding from what `uniform` leaves of a block: the lower bytes.
HASTE_HD constexpr u32 spare_bits(const PhiloxBlock& block) {
    return (block.word[0] << 24) | ((block.word[1] & 0xffu) << 16) |
           ((block.word[2] & 0xffu) << 8) | (block.word[3] & 0xffu);
}

/// The random numbers of one ray: counter (pixel, sample, node, dimension), key (seed, node), so a
/// ray draws the same numbers whatever thread, packet or order shades it.
struct RandomSource {
    u32 pixel;
    u32 sample;
    u64 node;
    u32 seed;

    HASTE_HD PhiloxBlock block(u32 dimension) const {
        return philox4x32({{pixel, sample, u32(node), dimension}}, seed, u32(node >> 32));
    }
};

}  // namespace haste
