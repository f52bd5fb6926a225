#include "cpu/planted.h"

#include "core/model/haste_model.h"
#include "cpu/pass.h"

namespace haste {

namespace {

using EveryFeature = Features<all_features>;

/// Visibility that glass does not block, where that is planted: walks from hit to hit.
class PlantedIntersector {
public:
    PlantedIntersector(const SceneView<float>& scene, bool glass_is_clear)
        : scene_(scene), inner_(scene), glass_is_clear_(glass_is_clear) {}

    [[nodiscard]] Hit<float> closest(const Ray<float>& ray) const { return inner_.closest(ray); }

    [[nodiscard]] bool occluded(const ShadowRay<float>& shadow) const {
        if (!glass_is_clear_) return inner_.occluded(shadow);
        Ray<float> ray{};
        ray.origin = shadow.origin;
        ray.direction = shadow.direction;
        // Surfaces that are let through shorten what is left of the segment, so the walk ends.
        float remaining = shadow.t_max;
        for (;;) {
            const Hit<float> hit = inner_.closest(ray);
            if (!hit.found() || hit.t >= remaining) return false;
            const Surface<float> surface = surface_at<EveryFeature>(scene_, ray, hit);
            const Material<float>& material =
                scene_.materials[scene_.shapes[surface.shape].material];
            const bool clear =
                material.kind == MaterialKind::dielectric || material.transmission > 0.0f;
            if (!clear && surface.shape != shadow.owner) return true;
            remaining -= hit.t;
            ray.origin = Watertight::Offset::apply(surface.point, surface.geometric_normal,
                                                   surface.scale, ray.direction);
        }
    }

private:
    const SceneView<float>& scene_;
    ImageIntersector<Watertight, EveryFeature> inner_;
    bool glass_is_clear_;
};

}  // namespace

PlantedReading planted_reading(const std::string& name) {
    PlantedReading reading;
    if (name == "none") return reading;
    if (name == "ambient_is_cosine_weighted") {
        reading.ambient_is_cosine_weighted = true;
    } else if (name == "lights_are_sampled_on_the_surface") {
        reading.lights_are_sampled_on_the_surface = true;
    } else if (name == "refraction_uses_the_unturned_normal") {
        reading.refraction_uses_the_unturned_normal = true;
    } else if (name == "lights_block_themselves") {
        reading.lights_block_themselves = true;
    } else if (name == "glass_lets_shadow_rays_through") {
        reading.glass_lets_shadow_rays_through = true;
    } else {
        throw std::invalid_argument("no reading is called " + name);
    }
    return reading;
}

RenderOutput render_planted(const HostScene& scene, const Settings<float>& settings, u32 samples,
                            const PlantedReading& reading, int threads) {
    Schedule schedule;
    schedule.threads = threads;
    return render_in_passes(
        scene, ModelKind::haste, settings, samples, schedule, [&](const PassRequest& request) {
            const PhongModel<Watertight, EveryFeature, false, PlantedReading> model(
                request.view, request.settings, reading);
            const PlantedIntersector intersector(request.view,
                                                 reading.glass_lets_shadow_rays_through);
            return depth_first_pass<decltype(model), PlantedIntersector, false>(
                request, request.view.camera, model, intersector);
        });
}

}  // namespace haste
