#pragma once

#include "core/base/features.h"
#include "core/base/settings.h"
#include "core/engine/ray_tree.h"
#include "engine/schedule.h"

namespace haste {

/// The features that a model has code for; of the others it makes nothing.
[[nodiscard]] u32 model_features(ModelKind model);

/// What a render needs of a scene's features, and of those that its settings ask for.
[[nodiscard]] u32 required_features(u32 of_scene, ModelKind model, const Settings<float>& settings);

/// The features that a program has: those that are required, and what the schedule adds to them.
[[nodiscard]] u32 compiled_features(u32 of_scene, ModelKind model, const Settings<float>& settings,
                                    const Schedule& schedule);

/// What a sample's rays can grow to with these features.
[[nodiscard]] RayTree ray_tree(ModelKind model, const Settings<float>& settings, u32 features);

/// Most rays that a depth-first walk of one sample can have waiting: every layer leaves a sibling
/// behind where there are two, and the ambient rays of one hit lie on top.
[[nodiscard]] u32 stack_capacity(ModelKind model, const Settings<float>& settings, u32 features);

}  // namespace haste
