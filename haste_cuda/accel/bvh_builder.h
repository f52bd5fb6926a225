#pragma once

#include "accel/host_scene.h"

namespace haste {

inline constexpr u32 max_bvh2_leaf = 4;  ///< primitives

struct BuiltBvh {
    Box bounds;
    std::vector<Bvh2Node> nodes;
    std::vector<u32> parents;  ///< of each node: its parent's index, doubled, plus the side
    std::vector<PrimitiveRecord<float>> records;
    BvhInfo info;
};

struct BuildQuality {
    u32 max_leaf = max_bvh2_leaf;
    double most_splits = 1;  ///< spatial splits, at most, a primitive
};

/// Builds with Embree's builder (surface-area heuristic with spatial splits) and lays the tree out
/// in depth-first order. The same tree at any number of threads; `threads` 0 means all. Throws
/// std::runtime_error with Embree's message, or where the tree is deeper than the traversal's
/// stack.
BuiltBvh build_bvh2(const SceneArrays& arrays, int threads, const BuildQuality& quality = {});

}  // namespace haste
