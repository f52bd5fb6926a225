#pragma once

#include "core/config.h"

namespace haste {

/// An axis-aligned box, rounded outwards.
struct Box {
    float lower[3];
    float upper[3];
};

/// An inner node of the binary BVH: the boxes of both children, so one fetch decides two descents.
/// count[i] = 0: child i is the node child[i]; else it is the leaf of count[i] primitive records
/// that begin at child[i].
struct alignas(16) Bvh2Node {
    Box box[2];
    u32 child[2];
    u32 count[2];
};

static_assert(sizeof(Bvh2Node) == 64, "half a 128-byte line, four 16-byte loads");

/// Deepest tree that the traversal's stack can follow; the builder refuses a deeper one.
inline constexpr u32 max_bvh_depth = 64;

}  // namespace haste
