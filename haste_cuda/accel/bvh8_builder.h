#pragma once

#include "accel/bvh_builder.h"
#include "core/base/bvh8.h"

namespace haste {

struct BuiltBvh8 {
    std::vector<Bvh8Node> nodes;
    std::vector<PrimitiveRecord<float>> records;
    BvhInfo info;
};

/// Collapses a binary BVH, which `build_bvh2` made, into one with eight children, optimal by the
/// surface-area heuristic, and compresses its boxes: Ylitie, Karras and Laine, Efficient Incoherent
/// Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017, section 3. The same at any time
/// and on any machine. Throws std::runtime_error where the result is deeper than the traversal's
/// stack. `info.build_seconds` includes those of the binary BVH.
BuiltBvh8 build_bvh8(const BuiltBvh& binary);

}  // namespace haste
