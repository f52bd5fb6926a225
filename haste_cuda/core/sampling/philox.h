#pragma once

#include "core/config.h"

namespace haste {

/// Four 32-bit words.
struct PhiloxBlock {
    u32 word[4];
};

/// Philox4x32-10: Salmon et al., Parallel Random Numbers: As Easy as 1, 2, 3, SC 2011.
HASTE_HD inline PhiloxBlock philox4x32(PhiloxBlock counter, u32 key0, u32 key1) {
    for (int round = 0; round < 10; ++round) {
        const u64 product0 = u64(0xd2511f53u) * counter.word[0];
        const u64 product1 = u64(0xcd9e8d57u) * counter.word[2];
        counter = {{u32(product1 >> 32) ^ counter.word[1] ^ key0, u32(product1),
                    u32(product0 >> 32) ^ counter.word[3] ^ key1, u32(product0)}};
        key0 += 0x9e3779b9u;
        key1 += 0xbb67ae85u;
    }
    return counter;
}

}  // namespace haste
