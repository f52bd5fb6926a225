#pragma once

#include "core/base/ray_query.h"
#include "core/base/scene_view.h"

namespace haste {

/// What the replay kernel is given: read by the host that fills it and the device that runs it. All
/// pointers are the device's.
struct ReplayParams {
    SceneView<float> scene;
    const RayQuery<float>* queries;
    QueryHit<float>* hits;
    u64 count;
};

}  // namespace haste
