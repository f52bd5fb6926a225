#pragma once

#include "core/engine/ray_tree.h"

namespace haste::cuda {

/// How the bytes of a queue are shared out among the lanes of `wavefront`, each of which holds a
/// packet with its hits and shadow rays beside the rays that wait.
struct WavefrontRoom {
    u64 lanes;   ///< as many as are asked for and leave packets their size, at least one
    u64 packet;  ///< rays that a lane traces at once: half of its bytes are enough for them
    u64 queue;   ///< rays that may wait in a lane

    /// `most_shadow_rays`: that the shading of one ray can ask for. Throws std::invalid_argument
    /// where `bytes` do not hold the rays of one sample and what one ray takes.
    [[nodiscard]] static WavefrontRoom fit(const RayTree& tree, u64 bytes, u64 packet, u64 lanes,
                                           u64 most_shadow_rays);
};

}  // namespace haste::cuda
