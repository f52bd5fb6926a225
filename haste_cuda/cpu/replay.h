#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/accel/tally.h"
#include "core/accel/traversal.h"
#include "core/engine/replay.h"
#include "core/precision.h"
#include "cpu/ray_batch.h"
#include "cpu/render.h"

namespace haste {

/// What a replay found, one entry a ray.
struct ReplayOutput {
    std::vector<QueryHit<float>> hits;
    std::vector<double> seconds;   ///< of each repeat, tracing alone: rays and hits lie in the
                                   ///< tracer's own memory
    std::optional<Tally> visited;  ///< by all rays together, where they were counted
};

/// How a replay is run on the processor: but for the precision it changes no hit.
struct ReplaySchedule {
    IntersectorKind intersector = IntersectorKind::haste;
    TraversalKind traversal = default_traversal;          ///< where haste intersects
    PrecisionKind precision = PrecisionKind::watertight;  ///< or fast
    int threads = 0;                                      ///< 0: all
    int repeats = 1;
    bool count = false;  ///< counts what is visited, in one repeat more that is not timed
};

/// Throws std::invalid_argument for a precision whose rays are no queries in single precision.
void check_replay_precision(PrecisionKind precision);

/// Throws std::invalid_argument unless there is something to time.
void check_repeats(int repeats);

/// Traces rays for their own sake, any number of threads side by side, and nothing is shaded.
/// `embree_scene` is the EmbreeScene, where Embree intersects.
ReplayOutput replay_cpu(const HostScene& scene, const RayBatch& rays, QueryKind kind,
                        const ReplaySchedule& schedule, const void* embree_scene = nullptr);

/// The loop that every intersector of the processor shares.
using ReplayLoop = void (*)(const void* intersector, std::span<const RayQuery<float>> queries,
                            std::span<QueryHit<float>> hits);

/// Embree's, from reference/embree; the intersector is an EmbreeScene.
ReplayLoop embree_replay(QueryKind kind);

}  // namespace haste
