#pragma once

#include "core/accel/tally.h"
#include "core/base/ray_query.h"
#include "core/base/scene_view.h"

namespace haste {

/// What the replay kernels are given: read by the host that fills it and the device that runs it.
/// All pointers are the device's.
struct ReplayParams {
    SceneView<float> scene;
    const RayQuery<float>* queries;
    QueryHit<float>* hits;
    u32 count;
    u32* next;       ///< of `replay_resident`: the first ray that nobody has taken
    Tally* visited;  ///< of a kernel that counts: by all rays together
};

}  // namespace haste
