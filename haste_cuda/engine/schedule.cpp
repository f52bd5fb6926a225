#include "engine/schedule.h"

#include <stdexcept>
#include <string>

#include "core/base/ray.h"
#include "core/engine/layer_plan.h"
#include "engine/requirements.h"

namespace haste {

namespace {

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

constexpr u64 ray_bytes = sizeof(Ray<float>);

void check_model(ModelKind model, const Settings<float>& settings) {
    constexpr u32 deepest = 65535;
    if (model == ModelKind::path) {
        if (settings.max_depth == 0 || settings.max_depth > deepest) {
            refuse("max_depth must be 1 .. 65535");
        }
        if (!(settings.clamp > 0)) refuse("clamp must be positive");
        return;
    }
    if (settings.max_layers == 0 || settings.max_layers > deepest) {
        refuse("max_layers must be 1 .. 65535");
    }
    const auto sensible = [](u32 count) { return count >= 1 && count <= deepest; };
    if (model == ModelKind::haste &&
        !(sensible(settings.light_samples) && sensible(settings.ambient_samples))) {
        refuse("light_samples and ambient_samples must be 1 .. 65535");
    }
}

/// The queue must hold a packet and what one sample needs; refused before any work.
void check_queue(const RayTree& tree, const Schedule& schedule) {
    const bool layers = schedule.engine == EngineKind::layers;
    const bool queue = schedule.engine == EngineKind::packets ||
                       schedule.engine == EngineKind::streams ||
                       schedule.engine == EngineKind::wavefront;
    if (!layers && !queue) return;
    const auto at_least = [&](u64 rays, const std::string& why) {
        if (schedule.queue_bytes / ray_bytes >= rays) return;
        refuse("queue_bytes must be at least " + std::to_string(rays * ray_bytes) + " " + why +
               ", not " + std::to_string(schedule.queue_bytes));
    };
    if (schedule.packet == 0) refuse("packet must hold at least 1 ray");
    constexpr u64 largest = u64(1) << 28;
    if (schedule.packet > largest) {
        refuse("packet must hold at most " + std::to_string(largest) + " rays");
    }
    at_least(schedule.packet, "to hold one packet");
    at_least(layers ? LayerPlan::need(tree) : tree.lifo_need(), "for the rays of one sample");
}

}  // namespace

TraversalKind image_traversal(EngineKind engine, u64 primitives) {
    // So few primitives are tested sooner than a hierarchy is walked (docs/performance.md, Images).
    constexpr u64 tiny_scene = 8;
    if (primitives <= tiny_scene) return TraversalKind::brute_force;
    // Kernels that have all of an image in them are at the limit of their registers already, and
    // their threads test primitives one by one: a small scene's wide nodes do not pay there.
    constexpr u64 small_scene = u64(1) << 16;
    const bool private_stacks =
        engine == EngineKind::depth_first || engine == EngineKind::persistent;
    return private_stacks && primitives < small_scene ? small_scene_traversal : default_traversal;
}

Vec3<float> film_ambient(ModelKind model, const Settings<float>& settings) {
    return model == ModelKind::whitted ? settings.ambient : Vec3<float>{0, 0, 0};
}

std::vector<double> layer_weights(const Schedule& schedule, const Settings<float>& settings,
                                  double reflectance) {
    std::vector<double> weights{1};
    if (schedule.accumulation == Accumulation::layer_weighted) {
        while (weights.size() < settings.max_layers)
            weights.push_back(weights.back() * reflectance);
    }
    return weights;
}

void check_block(int threads) {
    if (threads < 32 || threads > 1024 || threads % 32 != 0) {
        refuse("block must be a multiple of 32 from 32 to 1024, not " + std::to_string(threads));
    }
}

void check_settings(u32 features, ModelKind model, const Settings<float>& settings, u32 samples,
                    const Schedule& schedule) {
    if (samples == 0) refuse("samples must be at least 1");
    if (schedule.threads < 0) refuse("threads must not be negative");
    if (schedule.pass_samples == 0 || schedule.pass_samples > FixedPoint::max_pass_samples) {
        refuse("pass_samples must be 1 .. " + std::to_string(FixedPoint::max_pass_samples));
    }
    check_block(schedule.block);
    constexpr u32 most_streams = 64;
    if (schedule.streams == 0 || schedule.streams > most_streams) {
        refuse("streams must be 1 .. 64, not " + std::to_string(schedule.streams));
    }
    if (schedule.accumulation == Accumulation::layer_weighted) {
        if (schedule.engine != EngineKind::layers) {
            refuse("accumulation layer_weighted belongs to the engine layers");
        }
        if (model == ModelKind::path) {
            refuse("accumulation layer_weighted has one reflectance a scene, which path has not");
        }
    }
    check_model(model, settings);
    check_queue(ray_tree(model, settings, compiled_features(features, model, settings, schedule)),
                schedule);
}

}  // namespace haste
