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

/// A child in one word, as the traversal keeps it: an inner node's index, or above it a leaf's size
/// and then its first record.
inline constexpr u32 child_index_bits = 28;
inline constexpr u32 first_leaf_reference = 1u << child_index_bits;

HASTE_HD inline u32 child_reference(const Bvh2Node& node, int i) {
    return (node.count[i] << child_index_bits) | node.child[i];
}

/// Deepest tree that the traversal's stack can follow; the builder refuses a deeper one.
inline constexpr u32 max_bvh_depth = 64;

}  // namespace haste
