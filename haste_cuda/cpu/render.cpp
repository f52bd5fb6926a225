#include "cpu/render.h"

#include <tbb/global_control.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <span>

#include "accel/sha256.h"
#include "cpu/pass.h"

namespace haste {

namespace {

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

PassResult run(ModelKind model, const PassRequest& request) {
    if (request.schedule.intersector == IntersectorKind::embree) return embree_pass(model, request);
    switch (model) {
        case ModelKind::path:
            return watertight_path_pass(request);
        case ModelKind::haste:
            return watertight_haste_pass(request);
        default:
            return watertight_whitted_pass(request);
    }
}

}  // namespace

void check_settings(ModelKind model, const Settings<float>& settings, u32 samples,
                    const Schedule& schedule) {
    if (samples == 0) refuse("samples must be at least 1");
    if (schedule.packet == 0) refuse("packet must hold at least 1 ray");
    if (schedule.threads < 0) refuse("threads must not be negative");
    if (schedule.pass_samples == 0 || schedule.pass_samples > FixedPoint::max_pass_samples) {
        refuse("pass_samples must be 1 .. " + std::to_string(FixedPoint::max_pass_samples));
    }
    constexpr u32 deepest = 65535;
    if (model == ModelKind::path) {
        if (settings.max_depth == 0 || settings.max_depth > deepest) {
            refuse("max_depth must be 1 .. 65535");
        }
        return;
    }
    if (settings.max_layers == 0 || settings.max_layers > deepest) {
        refuse("max_layers must be 1 .. 65535");
    }
    if (model == ModelKind::haste &&
        (settings.light_samples == 0 || settings.ambient_samples == 0)) {
        refuse("light_samples and ambient_samples must be at least 1");
    }
}

struct PassFolder::State {
    FixedPoint format;
    u32 width, height;
    std::vector<double> sums;
    u64 non_finite = 0;
    Sha256 hash;
};

PassFolder::PassFolder(const FixedPoint& format, u32 width, u32 height)
    : state_(std::make_unique<State>(State{
          format, width, height, std::vector<double>(3 * std::size_t(width) * height), 0, {}})) {
    state_->hash.update(std::as_bytes(std::span(&state_->format.exponent, 1)));
}

PassFolder::~PassFolder() = default;

void PassFolder::fold(const PassFilm& film) {
    if (film.faults.overflow_pixel != FilmFaults{}.overflow_pixel) {
        const u32 pixel = film.faults.overflow_pixel;
        throw FilmOverflow("the film overflows at pixel (" + std::to_string(pixel % state_->width) +
                           ", " + std::to_string(pixel / state_->width) +
                           "): its sum left the range of 2^" +
                           std::to_string(state_->format.exponent + 63));
    }
    state_->hash.update(std::as_bytes(std::span(film.sums)));
    state_->non_finite += film.faults.non_finite;
    for (std::size_t i = 0; i < film.sums.size(); ++i) {
        state_->sums[i] += std::ldexp(double(film.sums[i]), state_->format.exponent);
    }
}

void PassFolder::finish(u32 samples, RenderOutput& output) {
    output.mean = std::move(state_->sums);
    for (double& value : output.mean) value /= samples;
    output.film_sha256 = state_->hash.hex();
    output.non_finite = state_->non_finite;
}

RenderOutput render_in_passes(const HostScene& scene, ModelKind model,
                              const Settings<float>& settings, u32 samples,
                              const Schedule& schedule,
                              const std::function<PassResult(const PassRequest&)>& run_pass,
                              const void* embree_scene) {
    check_settings(model, settings, samples, schedule);
    std::unique_ptr<tbb::global_control> limit;
    if (schedule.threads > 0) {
        limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                      std::size_t(schedule.threads));
    }
    PassRequest request{
        scene.view(), settings, scene.film_format(settings), schedule, embree_scene, 0, 0};
    PassFolder folder(request.format, request.view.camera.width, request.view.camera.height);
    RenderOutput output;
    for (u32 first = 0; first < samples; first += schedule.pass_samples) {
        request.first_sample = first;
        request.samples = std::min(schedule.pass_samples, samples - first);
        const auto start = std::chrono::steady_clock::now();
        const PassResult pass = run_pass(request);
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
        output.seconds += elapsed.count();
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
