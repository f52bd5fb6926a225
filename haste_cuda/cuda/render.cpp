#include "cuda/render.h"

#include <algorithm>

#include "cuda/device_film.h"
#include "cuda/engines/engine.h"
#include "cuda/renderer_state.h"
#include "engine/pass_folder.h"
#include "engine/requirements.h"

namespace haste::cuda {

Renderer::Renderer() : state_(std::make_unique<State>()) {}

Renderer::~Renderer() = default;

Renderer& Renderer::instance() {
    // Never destroyed: at process exit the driver may be gone before static objects are.
    static Renderer* const renderer = new Renderer;
    return *renderer;
}

namespace {

const char* model_name(ModelKind model) {
    switch (model) {
        case ModelKind::path:
            return "path";
        case ModelKind::haste:
            return "haste";
        default:
            return "whitted";
    }
}

u64 most_shadow_rays(ModelKind model, const Settings<float>& settings, u32 lights) {
    switch (model) {
        case ModelKind::path:
            return 1;
        case ModelKind::haste:
            return u64(lights) * settings.light_samples;
        default:
            return lights;
    }
}

/// Adds to a sum of the film that are less need not look at it: see `FilmTarget`.
u64 looks_from(const Schedule& schedule, const RayTree& tree, u64 shadow_rays, u32 samples) {
    constexpr u64 most = u64(FilmSum::max_sum);
    const auto times = [](u64 a, u64 b) { return b != 0 && a > most / b ? most : a * b; };
    u64 adds = 1;  // one a sample where a thread walks its whole tree
    if (schedule.engine != EngineKind::depth_first && schedule.engine != EngineKind::persistent) {
        u64 rays = 0;
        u64 generation = 1;
        for (u32 i = 0; i < tree.generations && rays < most / 2; ++i) {
            rays = std::min(most / 2, rays + generation);
            generation = std::min(most / 4, times(generation, tree.children));
        }
        adds = schedule.engine == EngineKind::wavefront ? times(rays, 1 + shadow_rays) : rays;
    }
    return most / times(adds, samples);
}

KernelSpecification specification_of(const HostScene& host, ModelKind model,
                                     const Settings<float>& settings, const Schedule& schedule,
                                     TraversalKind traversal) {
    KernelSpecification specification;
    specification.model = model_name(model);
    specification.precision = name_of(schedule.precision);
    specification.features = compiled_features(host.features(), model, settings, schedule);
    specification.traversal = name_of(traversal);
    specification.stack_capacity = int(stack_capacity(model, settings, specification.features));
    specification.film = schedule.film == FilmKind::int64 ? "int64" : "float_atomic";
    specification.layered = schedule.accumulation == Accumulation::layer_weighted;
    specification.count_rays = schedule.count_rays;
    return specification;
}

}  // namespace

CudaOutput Renderer::render(const HostScene& host, std::shared_ptr<Scene>& scene, ModelKind model,
                            const Settings<float>& settings, u32 samples,
                            const Schedule& schedule) {
    check_settings(host.features(), model, settings, samples, schedule);
    CudaOutput output;
    const SceneArrays& arrays = host.arrays();
    const TraversalKind traversal = schedule.traversal.value_or(image_traversal(
        schedule.engine, arrays.triangle_shape.size() + arrays.sphere_radius.size()));
    output.traversal = name_of(traversal);
    output.upload_seconds = state_->upload(host, scene, traversal);
    output.scene_bytes = scene->device.bytes();

    RenderParams pass{};
    pass.scene = scene->device.view();
    pass.settings = settings;
    const Camera<float>& camera = pass.scene.camera;
    std::vector<double> weights = layer_weights(schedule, settings, host.common_reflectance());
    DeviceFilm film(3 * std::size_t(camera.width) * camera.height * weights.size(), schedule.film,
                    host.film_format(film_ambient(model, settings)));
    pass.film = film.target();
    pass.rays = film.rays();

    const double built_before = state_->kernels.build_seconds();
    const KernelSpecification kernel = specification_of(host, model, settings, schedule, traversal);
    const RayTree tree = ray_tree(model, settings, kernel.features);
    const u64 shadow_rays = most_shadow_rays(model, settings, pass.scene.light_count);
    const std::unique_ptr<Engine> engine = make_engine({.device = state_->device,
                                                        .kernels = state_->kernels,
                                                        .stream = state_->stream,
                                                        .kernel = kernel,
                                                        .schedule = schedule,
                                                        .tree = tree,
                                                        .most_shadow_rays = shadow_rays});
    output.compile_seconds = state_->kernels.build_seconds() - built_before;
    output.compile_cached = engine->main_kernel().cached();
    output.registers = engine->main_kernel().attributes().registers;
    output.local_bytes = engine->main_kernel().attributes().local_bytes;

    PassFolder folder(pass.film.format, camera.width, camera.height, std::move(weights));
    for (u32 first = 0; first < samples; first += schedule.pass_samples) {
        pass.range = {first, std::min(schedule.pass_samples, samples - first), settings.seed};
        pass.film.looks_from = looks_from(schedule, tree, shadow_rays, pass.range.samples);
        film.clear(state_->stream);
        state_->stream.synchronize();
        const EnginePass done = engine->run(pass);
        output.render.work.append(done.work, output.render.seconds);
        output.render.seconds += done.seconds;
        output.render.peak_queue_bytes =
            std::max(output.render.peak_queue_bytes, done.peak_queue_bytes);
        output.render.rays += film.download_rays();
        folder.fold(film.download());
    }
    folder.finish(samples, output.render);
    return output;
}

}  // namespace haste::cuda
