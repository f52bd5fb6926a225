#include "cuda/render.h"

#include <algorithm>
#include <stdexcept>

#include "core/engine/depth_first.h"
#include "cuda/event.h"
#include "cuda/kernels/depth_first_params.h"
#include "cuda/renderer_state.h"

namespace haste::cuda {

Renderer::Renderer() : state_(std::make_unique<State>()) {}

Renderer::~Renderer() = default;

Renderer& Renderer::instance() {
    // Never destroyed: at process exit the driver may be gone before static objects are.
    static Renderer* const renderer = new Renderer;
    return *renderer;
}

void check_block(int threads) {
    if (threads < 32 || threads > 1024 || threads % 32 != 0) {
        throw std::invalid_argument("block must be a multiple of 32 from 32 to 1024, not " +
                                    std::to_string(threads));
    }
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

/// The private stack of a kernel: as many rays as the model's tree can have pending.
u32 stack_capacity(ModelKind model, const Settings<float>& settings) {
    switch (model) {
        case ModelKind::path:
            return depth_first_capacity(1, 1, 0);
        case ModelKind::haste:
            return depth_first_capacity(settings.max_layers, 2, settings.ambient_samples);
        default:
            return depth_first_capacity(settings.max_layers, 2, 0);
    }
}

}  // namespace

CudaOutput Renderer::render(const HostScene& host, std::shared_ptr<Scene>& scene, ModelKind model,
                            const Settings<float>& settings, u32 samples,
                            const CudaSchedule& schedule) {
    Schedule shared;
    shared.pass_samples = schedule.pass_samples;
    check_settings(model, settings, samples, shared);
    check_block(schedule.block);
    CudaOutput output;
    output.upload_seconds = state_->upload(host, scene);
    output.scene_bytes = scene->device.bytes();

    KernelSpecification specification;
    specification.model = model_name(model);
    specification.features = host.features();
    specification.stack_capacity = int(stack_capacity(model, settings));
    specification.count_rays = schedule.count_rays;
    const Kernel& kernel = state_->kernels.get(specification);
    output.compile_seconds = kernel.build_seconds();
    output.compile_cached = kernel.cached();
    output.registers = kernel.attributes().registers;
    output.local_bytes = kernel.attributes().local_bytes;

    DepthFirstParams parameters;
    parameters.scene = scene->device.view();
    parameters.settings = settings;
    parameters.format = host.film_format(settings);
    const Camera<float>& camera = parameters.scene.camera;
    DeviceBuffer<i64> sums(3 * std::size_t(camera.width) * camera.height);
    DeviceBuffer<FilmFaults> faults(1);
    DeviceBuffer<RayCounts> rays(1);
    parameters.sums = sums.data();
    parameters.faults = faults.data();
    parameters.rays = rays.data();

    PassFolder folder(parameters.format, camera.width, camera.height);
    const Stream& stream = state_->stream;
    Event start;
    Event end;
    for (u32 first = 0; first < samples; first += schedule.pass_samples) {
        parameters.first_sample = first;
        parameters.samples = std::min(schedule.pass_samples, samples - first);
        const FilmFaults no_faults;
        faults.upload(std::span(&no_faults, 1));
        sums.clear(stream);
        rays.clear(stream);
        start.record(stream);
        kernel.launch(Launch::for_items(parameters.items(), schedule.block), state_->stream,
                      parameters);
        end.record(stream);
        output.render.seconds += seconds_between(start, end);
        PassFilm film;
        film.sums = sums.download();
        film.faults = faults.download()[0];
        output.render.rays += rays.download()[0];
        folder.fold(film);
    }
    folder.finish(samples, output.render);
    return output;
}

}  // namespace haste::cuda
