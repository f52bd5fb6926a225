#pragma once

#include "core/engine/ray_tree.h"

namespace haste {

/// Breadth first in bounded memory, after Segovia et al., Iterative Layer-Based Raytracing on CUDA,
/// IPCCC 2009: one buffer of rays a generation. A slice of a generation is traced into the buffer
/// of the next, which is emptied before the generation goes on. Where the buffers hold a whole
/// layer, that is Segovia's order; where they do not, layers are cut and nothing fails.
struct LayerPlan {
    u64 slice;   ///< most rays traced at once
    u64 buffer;  ///< rays that a generation's buffer holds

    /// Fewest rays that all buffers together must hold: all children of one ray a generation.
    HASTE_HD static constexpr u64 need(const RayTree& tree) {
        return u64(tree.generations - 1) * tree.children;
    }

    /// Requires capacity >= need(tree).
    HASTE_HD static constexpr LayerPlan fit(const RayTree& tree, u64 capacity, u64 packet) {
        const u64 need_ = need(tree);
        const u64 room = need_ == 0 ? packet : capacity / need_;
        const u64 slice = packet < room ? packet : room;
        return {slice, slice * tree.children};
    }
};

}  // namespace haste
