#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "accel/host_scene.h"
#include "core/engine/ray_counts.h"
#include "core/film/film_view.h"

namespace haste {

enum class ModelKind { path, haste, whitted };
enum class EngineKind { depth_first, packets };
enum class QueueOrder { fifo, lifo };
enum class IntersectorKind { haste, embree };

/// How a render is scheduled: none of it changes a bit of the film.
struct Schedule {
    EngineKind engine = EngineKind::depth_first;
    IntersectorKind intersector = IntersectorKind::haste;
    u64 packet = 65536;  ///< rays a packet
    QueueOrder order = QueueOrder::fifo;
    int threads = 0;  ///< 0: all
    bool count_rays = false;
    u32 pass_samples = FixedPoint::max_pass_samples;
};

/// A pass's integer sums, 3 a pixel.
struct PassFilm {
    std::vector<i64> sums;
    FilmFaults faults;
};

/// A finished render.
struct RenderOutput {
    std::vector<double> mean;  ///< height x width x 3, radiance averaged over the samples
    std::string film_sha256;   ///< of the integer films of all passes and their exponent
    double seconds = 0;        ///< tracing alone
    RayCounts rays;
    u64 peak_queue_bytes = 0;
    u64 non_finite = 0;  ///< contributions dropped because they were not finite
};

/// A contribution or a sum left the film's range.
class FilmOverflow : public std::overflow_error {
    using std::overflow_error::overflow_error;
};

/// What one pass needs; engines fill `film`, `rays` and `peak_queue_bytes`.
struct PassRequest {
    SceneView<float> view;
    Settings<float> settings;
    FixedPoint format;
    Schedule schedule;
    const void* embree_scene = nullptr;  ///< EmbreeScene, where Embree intersects
    u32 first_sample = 0;
    u32 samples = 0;
};

struct PassResult {
    PassFilm film;
    RayCounts rays;
    u64 peak_queue_bytes = 0;
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

/// Throws std::invalid_argument naming the setting that makes no sense.
void check_settings(ModelKind model, const Settings<float>& settings, u32 samples,
                    const Schedule& schedule);

/// Folds a pass into the sums and the hash of a render; shared by all engines.
class PassFolder {
public:
    PassFolder(const FixedPoint& format, u32 width, u32 height);
    ~PassFolder();
    /// Throws FilmOverflow.
    void fold(const PassFilm& film);
    /// Mean over `samples`, and the hash of all passes.
    void finish(u32 samples, RenderOutput& output);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace haste
