#include "cpu/render.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "accel/scene_fp64.h"
#include "cpu/pass.h"
#include "engine/requirements.h"
#include "host/stopwatch.h"
#include "host/thread_limit.h"

namespace haste {

namespace {

PassResult run(ModelKind model, const PassRequest& request) {
    if (request.schedule.intersector == IntersectorKind::embree) return embree_pass(model, request);
    if (request.schedule.precision == PrecisionKind::fast) return fast_pass(model, request);
    if (request.schedule.precision == PrecisionKind::fp64) return fp64_pass(model, request);
    switch (model) {
        case ModelKind::path:
            return watertight_path_pass(request);
        case ModelKind::haste:
            return watertight_haste_pass(request);
        default:
            return watertight_whitted_pass(request);
    }
}

void check_precision(const Schedule& schedule) {
    if (schedule.precision == PrecisionKind::watertight) return;
    if (schedule.engine != EngineKind::depth_first ||
        schedule.intersector != IntersectorKind::haste) {
        throw std::invalid_argument(
            "the precisions fast and fp64 run with the engine depth_first and the intersector "
            "haste only");
    }
}

}  // namespace

RenderOutput render_in_passes(const HostScene& scene, ModelKind model,
                              const Settings<float>& settings, u32 samples,
                              const Schedule& schedule,
                              const std::function<PassResult(const PassRequest&)>& run_pass,
                              const void* embree_scene) {
    check_settings(scene.features(), model, settings, samples, schedule);
    check_precision(schedule);
    const ThreadLimit limit(schedule.threads);
    std::vector<double> weights = layer_weights(schedule, settings, scene.common_reflectance());
    PassRequest request;
    request.view = scene.view();
    request.settings = settings;
    request.format = scene.film_format(settings);
    request.schedule = schedule;
    const u32 features = compiled_features(scene.features(), model, settings, schedule);
    request.features = features;
    request.tree = ray_tree(model, settings, features);
    request.stack_capacity = stack_capacity(model, settings, features);
    request.film_layers = u32(weights.size());
    request.embree_scene = embree_scene;
    std::unique_ptr<const SceneFp64> wide;
    if (schedule.precision == PrecisionKind::fp64) wide = std::make_unique<SceneFp64>(scene);
    request.scene_fp64 = wide.get();
    PassFolder folder(request.format, request.view.camera.width, request.view.camera.height,
                      std::move(weights));
    RenderOutput output;
    for (u32 first = 0; first < samples; first += schedule.pass_samples) {
        request.first_sample = first;
        request.samples = std::min(schedule.pass_samples, samples - first);
        const Stopwatch watch;
        const PassResult pass = run_pass(request);
        output.seconds += watch.seconds();
        output.work.launches += pass.launches;
        output.rays += pass.rays;
        output.peak_queue_bytes = std::max(output.peak_queue_bytes, pass.peak_queue_bytes);
        folder.fold(pass.film);
    }
    folder.finish(samples, output);
    return output;
}

RenderOutput render_cpu(const HostScene& scene, ModelKind model, const Settings<float>& settings,
                        u32 samples, const Schedule& schedule, const void* embree_scene) {
    return render_in_passes(
        scene, model, settings, samples, schedule,
        [model](const PassRequest& request) { return run(model, request); }, embree_scene);
}

}  // namespace haste
