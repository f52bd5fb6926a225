#pragma once

#include <optional>
#include <vector>

#include "core/base/settings.h"
#include "core/base/traversal_kind.h"
#include "core/engine/ray_tree.h"
#include "core/film/fixed_point.h"
#include "core/precision.h"

namespace haste {

enum class ModelKind { path, haste, whitted };
enum class IntersectorKind { haste, embree };

/// How rays are scheduled: docs/engines.md.
enum class EngineKind { depth_first, packets, streams, layers, wavefront, persistent };

/// Which end of the queue a packet is taken from.
enum class QueueOrder { fifo, lifo };

/// `packets` on the GPU: whether device memory is allocated for each packet, as in the paper.
enum class Allocation { per_packet, once };

/// What a film adds up: integers, in any order to the same bits, or the paper's floats.
enum class FilmKind { int64, float_atomic };

/// `layers`: contributions that rays carry (equation 9) or weights of layers (equation 8).
enum class Accumulation { flat, layer_weighted };

/// How a render is scheduled. But for the film's kind, the accumulation and the precision, none of
/// it changes a bit of the film.
struct Schedule {
    EngineKind engine = EngineKind::depth_first;
    IntersectorKind intersector = IntersectorKind::haste;
    std::optional<TraversalKind> traversal;  ///< on the GPU; `image_traversal` by itself
    u64 packet = 65536;                      ///< most rays traced at once
    QueueOrder order = QueueOrder::fifo;
    u64 queue_bytes = u64(4) << 30;  ///< most that waiting rays may take
    Accumulation accumulation = Accumulation::flat;
    Allocation allocation = Allocation::once;
    FilmKind film = FilmKind::int64;
    u32 streams = 3;  ///< of the engines `streams` and `wavefront`
    int threads = 0;  ///< of the processor; 0: all
    int block = 128;  ///< threads of a CUDA block
    PrecisionKind precision = PrecisionKind::watertight;
    u32 more_features = 0;  ///< compiled in though nothing requires them: haste::FeatureBits
    bool count_rays = false;
    bool record_spans = false;  ///< of `ScheduleWork`, on the GPU
    u32 pass_samples = FixedPoint::max_pass_samples;
};

/// The constant radiance that a model adds to a film, from which the film takes its range: only
/// `whitted` has one, and next to it the light of a dim scene would be below the film's unit.
[[nodiscard]] Vec3<float> film_ambient(ModelKind model, const Settings<float>& settings);

/// How the GPU finds what the rays of an image hit, where the schedule leaves it open.
[[nodiscard]] TraversalKind image_traversal(EngineKind engine, u64 primitives);

/// Weights of the film's layers: R^k for `layer_weighted` (equation 8), else {1}.
[[nodiscard]] std::vector<double> layer_weights(const Schedule& schedule,
                                                const Settings<float>& settings,
                                                double reflectance);

/// Throws std::invalid_argument if CUDA blocks of so many threads make no sense.
void check_block(int threads);

/// Throws std::invalid_argument naming the setting that makes no sense; `features` are those of the
/// scene.
void check_settings(u32 features, ModelKind model, const Settings<float>& settings, u32 samples,
                    const Schedule& schedule);

}  // namespace haste
