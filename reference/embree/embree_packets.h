#pragma once

#include <vector>

#include "core/engine/replay.h"
#include "cpu/ray_batch.h"
#include "reference/embree/embree_scene.h"

namespace haste {

/// How rays are handed to Embree: it changes times, and which hits `fast` misses.
struct EmbreeCall {
    int width = 1;    ///< rays a call: 1, 8 or 16
    int threads = 0;  ///< 0: all
    int repeats = 1;
};

struct EmbreeReplay {
    std::vector<QueryHit<float>> hits;  ///< of the last repeat
    std::vector<double> seconds;        ///< of each repeat, tracing alone
};

/// Traces rays for their own sake, and nothing is shaded. Throws std::invalid_argument saying why
/// Embree has no such packets here: spheres are tested by a callback that takes one ray.
EmbreeReplay replay_embree(const EmbreeScene& scene, const RayBatch& rays, QueryKind kind,
                           const EmbreeCall& call);

}  // namespace haste
