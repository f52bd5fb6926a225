#include "engine/requirements.h"

#include <algorithm>

namespace haste {

namespace {

constexpr u32 specular_features = feature_mirror | feature_transmission | feature_dielectric;

/// Children of the next layer that a hit can have: a mirrored and a refracted ray.
u32 bounce_children(u32 features) {
    if (!(features & feature_bounces)) return 0;
    const bool reflects = features & (feature_mirror | feature_dielectric);
    const bool refracts = features & (feature_transmission | feature_dielectric);
    return u32(reflects) + u32(refracts);
}

u32 ambient_children(ModelKind model, const Settings<float>& settings, u32 features) {
    return model == ModelKind::haste && (features & feature_ambient) ? settings.ambient_samples : 0;
}

}  // namespace

u32 model_features(ModelKind model) {
    switch (model) {
        case ModelKind::path:
            return all_features & ~feature_ambient;
        default:
            return all_features & ~(feature_environment | feature_twosided | feature_clamp);
    }
}

u32 required_features(u32 of_scene, ModelKind model, const Settings<float>& settings) {
    u32 features = of_scene;
    if (model == ModelKind::path) {
        if (settings.clamp < Numeric<float>::infinity) features |= feature_clamp;
        if (settings.max_depth > 1) features |= feature_bounces;
    } else if (settings.max_layers > 1 && (of_scene & specular_features)) {
        features |= feature_bounces;
    }
    return features & model_features(model);
}

u32 compiled_features(u32 of_scene, ModelKind model, const Settings<float>& settings,
                      const Schedule& schedule) {
    return required_features(of_scene, model, settings) |
           (schedule.more_features & model_features(model));
}

RayTree ray_tree(ModelKind model, const Settings<float>& settings, u32 features) {
    if (model == ModelKind::path) return {settings.max_depth, 1};
    const u32 bounces = bounce_children(features);
    const u32 ambient = ambient_children(model, settings, features);
    // Ambient rays are one generation more than the layers.
    return {(bounces > 0 ? settings.max_layers : 1) + (ambient > 0 ? 1 : 0),
            std::max(1u, bounces + ambient)};
}

u32 stack_capacity(ModelKind model, const Settings<float>& settings, u32 features) {
    if (model == ModelKind::path) return 1;
    const u32 bounces = bounce_children(features);
    const u32 ambient = ambient_children(model, settings, features);
    if (bounces == 0) return std::max(1u, ambient);
    return (settings.max_layers - 1) * (bounces - 1) + 1 + ambient;
}

}  // namespace haste
