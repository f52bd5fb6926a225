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

/// `FilmTarget::unchecked_below` of a pass of so many samples: the range of a sum over the most
/// adds that it may get.
u64 unchecked_below(EngineKind engine, const RayTree& tree, u64 shadow_rays, u32 samples) {
    const u64 a_sample = u64(FilmSum::max_sum) / samples;
    switch (engine) {
        case EngineKind::depth_first:
        case EngineKind::persistent:
            // A thread walks the whole tree before it adds.
            return a_sample;
        case EngineKind::wavefront:
            return a_sample / tree.most_rays() / (1 + shadow_rays);
        default:
            return a_sample / tree.most_rays();
    }
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
        pass.film.unchecked_below =
            unchecked_below(schedule.engine, tree, shadow_rays, pass.range.samples);
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
