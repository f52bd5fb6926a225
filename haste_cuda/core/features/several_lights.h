#pragma once

#include "core/base/scene_view.h"

namespace haste {

/// `path`: one of `count` emitters, all equally likely; `bits` are random.
template <class Real>
HASTE_HD u32 choose_emitter(const SceneView<Real>&, u32 bits, u32 count) {
    return u32((u64(bits >> 8) * count) >> 24);
}

/// Calls visit(i) for every light but `own`.
template <class Real, class Visit>
HASTE_HD void visit_other_lights(const SceneView<Real>& scene, u32 own, Visit&& visit) {
    for (u32 i = 0; i < scene.light_count; ++i) {
        if (i != own) visit(i);
    }
}

}  // namespace haste
