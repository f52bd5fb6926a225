#include "cpu/replay.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <stdexcept>

#include "core/features/all.h"
#include "core/precision.h"
#include "cpu/replay_loop.h"
#include "host/stopwatch.h"
#include "host/thread_limit.h"

namespace haste {

namespace {

void run(ReplayLoop loop, const void* intersector, std::span<const RayQuery<float>> queries,
         int repeats, ReplayOutput& output) {
    for (int i = 0; i < repeats; ++i) {
        const Stopwatch watch;
        loop(intersector, queries, output.hits);
        output.seconds.push_back(watch.seconds());
    }
}

/// What the rays of a replay visit, on an intersector `I` that counts.
template <QueryKind Kind, class I>
Tally count(const SceneView<float>& view, std::span<const RayQuery<float>> queries) {
    using Range = tbb::blocked_range<std::size_t>;
    return tbb::parallel_reduce(
        Range(0, queries.size()), Tally{},
        [&](const Range& range, Tally tally) {
            const I intersector(view, &tally);
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                answer<Kind>(intersector, queries[i]);
            }
            return tally;
        },
        [](const Tally& a, const Tally& b) {
            return Tally{a.nodes + b.nodes, a.primitives + b.primitives};
        });
}

template <TraversalKind K, class P, u32 Kinds>
void run_on(const HostScene& scene, QueryKind kind, std::span<const RayQuery<float>> queries,
            const ReplaySchedule& schedule, ReplayOutput& output) {
    using I = IntersectorOf<K, P, Features<Kinds>>;
    using Counting = IntersectorOf<K, P, Features<Kinds>, Tally>;
    const SceneView<float> view = scene.view(K);
    const I intersector(view);
    run(replay_loop_of<I>(kind), &intersector, queries, schedule.repeats, output);
    if (!schedule.count) return;
    output.visited = kind == QueryKind::any_hit
                         ? count<QueryKind::any_hit, Counting>(view, queries)
                         : count<QueryKind::closest, Counting>(view, queries);
}

template <TraversalKind K, class P>
void run_on(const HostScene& scene, QueryKind kind, std::span<const RayQuery<float>> queries,
            const ReplaySchedule& schedule, ReplayOutput& output) {
    switch (scene.features() & (feature_triangles | feature_spheres)) {
        case feature_triangles:
            run_on<K, P, feature_triangles>(scene, kind, queries, schedule, output);
            break;
        case feature_spheres:
            run_on<K, P, feature_spheres>(scene, kind, queries, schedule, output);
            break;
        default:
            run_on<K, P, feature_triangles | feature_spheres>(scene, kind, queries, schedule,
                                                              output);
    }
}

template <class P>
void run_in(const HostScene& scene, QueryKind kind, std::span<const RayQuery<float>> queries,
            const ReplaySchedule& schedule, ReplayOutput& output) {
    switch (schedule.traversal) {
        case TraversalKind::brute_force:
            run_on<TraversalKind::brute_force, P>(scene, kind, queries, schedule, output);
            break;
        case TraversalKind::bvh2:
            run_on<TraversalKind::bvh2, P>(scene, kind, queries, schedule, output);
            break;
        case TraversalKind::bvh2_stackless:
            run_on<TraversalKind::bvh2_stackless, P>(scene, kind, queries, schedule, output);
            break;
        case TraversalKind::bvh8:
            run_on<TraversalKind::bvh8, P>(scene, kind, queries, schedule, output);
            break;
    }
}

}  // namespace

void check_replay_precision(PrecisionKind precision) {
    if (precision == PrecisionKind::fp64) {
        throw std::invalid_argument("rays are replayed in the precisions watertight and fast only");
    }
}

void check_repeats(int repeats) {
    if (repeats < 1) throw std::invalid_argument("repeats must be at least 1");
}

ReplayOutput replay_cpu(const HostScene& scene, const RayBatch& rays, QueryKind kind,
                        const ReplaySchedule& schedule, const void* embree_scene) {
    if (schedule.threads < 0) throw std::invalid_argument("threads must not be negative");
    check_repeats(schedule.repeats);
    if (schedule.count && schedule.intersector == IntersectorKind::embree) {
        throw std::invalid_argument("Embree does not count what it visits");
    }
    check_replay_precision(schedule.precision);
    const std::span queries = rays.queries();
    const ThreadLimit limit(schedule.threads);
    ReplayOutput output;
    output.hits.resize(queries.size());
    if (schedule.intersector == IntersectorKind::embree) {
        run(embree_replay(kind), embree_scene, queries, schedule.repeats, output);
        return output;
    }
    if (schedule.precision == PrecisionKind::fast) {
        run_in<Fast>(scene, kind, queries, schedule, output);
    } else {
        run_in<Watertight>(scene, kind, queries, schedule, output);
    }
    return output;
}

}  // namespace haste
