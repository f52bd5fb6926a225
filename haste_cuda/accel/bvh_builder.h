#pragma once

#include "accel/host_scene.h"

namespace haste {

struct BuiltBvh {
    std::vector<Bvh2Node> nodes;
    std::vector<PrimitiveRecord<float>> records;
    BvhInfo info;
};

/// Builds with Embree's builder (surface-area heuristic with spatial splits) and lays the tree out
/// in depth-first order. The same tree at any number of threads; `threads` 0 means all. Throws
/// std::runtime_error with Embree's message, or where the tree is deeper than the traversal's
/// stack.
BuiltBvh build_bvh2(const SceneArrays& arrays, int threads);

}  // namespace haste
