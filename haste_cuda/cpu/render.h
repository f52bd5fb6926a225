#pragma once

#include <functional>

#include "accel/host_scene.h"
#include "core/sampling/sample_range.h"
#include "engine/pass_folder.h"
#include "engine/schedule.h"

namespace haste {

/// What one pass needs; engines fill `film`, `rays` and `peak_queue_bytes`.
struct PassRequest {
    SceneView<float> view;
    Settings<float> settings;
    FixedPoint format;
    Schedule schedule;
    u32 features = 0;  ///< of the program: those required, and what the schedule adds
    RayTree tree;
    u32 stack_capacity = 1;              ///< of `depth_first`
    u32 film_layers = 1;                 ///< films that `layers` fills, each 3 sums a pixel
    const void* embree_scene = nullptr;  ///< EmbreeScene, where Embree intersects
    const void* scene_fp64 = nullptr;    ///< SceneFp64, where the precision is that
    u32 first_sample = 0;
    u32 samples = 0;

    [[nodiscard]] SampleRange range() const { return {first_sample, samples, settings.seed}; }
    [[nodiscard]] std::size_t film_size() const {
        return 3 * std::size_t(view.camera.width) * view.camera.height * film_layers;
    }
};

struct PassResult {
    PassFilm film;
    RayCounts rays;
    u64 peak_queue_bytes = 0;
    u64 launches = 1;
};

/// Runs `run_pass` over all passes of a render and folds them: what every CPU engine shares.
RenderOutput render_in_passes(const HostScene& scene, ModelKind model,
                              const Settings<float>& settings, u32 samples,
                              const Schedule& schedule,
                              const std::function<PassResult(const PassRequest&)>& run_pass,
                              const void* embree_scene = nullptr);

/// Renders on the CPU in passes, folds them in double precision and in order.
/// Throws std::invalid_argument on impossible settings and FilmOverflow naming the pixel.
RenderOutput render_cpu(const HostScene& scene, ModelKind model, const Settings<float>& settings,
                        u32 samples, const Schedule& schedule, const void* embree_scene = nullptr);

}  // namespace haste
