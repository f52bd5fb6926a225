#include "cpu/replay.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/accel/bvh2_intersector.h"
#include "core/precision.h"
#include "cpu/replay_loop.h"
#include "host/stopwatch.h"
#include "host/thread_limit.h"

namespace haste {

namespace {

bool finite(const Vec3f& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

[[noreturn]] void refuse(std::size_t ray, const char* what) {
    throw std::invalid_argument("ray " + std::to_string(ray) + ": " + what);
}

void run(ReplayLoop loop, const void* intersector, std::span<const RayQuery<float>> queries,
         ReplayOutput& output) {
    const Stopwatch watch;
    loop(intersector, queries, output.hits);
    output.seconds = watch.seconds();
}

template <u32 Kinds>
void run_on_bvh2(const HostScene& scene, QueryKind kind, std::span<const RayQuery<float>> queries,
                 ReplayOutput& output) {
    using I = Bvh2Intersector<Watertight, Features<Kinds>>;
    const SceneView<float> view = scene.view();
    const I intersector(view);
    run(replay_loop_of<I>(kind), &intersector, queries, output);
}

}  // namespace

void check_queries(std::span<const RayQuery<float>> queries) {
    for (std::size_t i = 0; i < queries.size(); ++i) {
        const RayQuery<float>& query = queries[i];
        if (!finite(query.origin)) refuse(i, "its origin is not finite");
        if (!finite(query.direction)) refuse(i, "its direction is not finite");
        if (is_zero(query.direction)) refuse(i, "its direction is zero");
        if (!(query.t_min >= 0) || std::isinf(query.t_min)) {
            refuse(i, "t_min must be finite and not negative");
        }
        if (!(query.t_max >= query.t_min)) refuse(i, "t_max must not be below t_min");
    }
}

ReplayOutput replay_cpu(const HostScene& scene, std::span<const RayQuery<float>> queries,
                        QueryKind kind, const ReplaySchedule& schedule, const void* embree_scene) {
    if (schedule.threads < 0) throw std::invalid_argument("threads must not be negative");
    check_queries(queries);
    const ThreadLimit limit(schedule.threads);
    ReplayOutput output;
    output.hits.resize(queries.size());
    if (schedule.intersector == IntersectorKind::embree) {
        run(embree_replay(kind), embree_scene, queries, output);
        return output;
    }
    switch (scene.features() & (feature_triangles | feature_spheres)) {
        case feature_triangles:
            run_on_bvh2<feature_triangles>(scene, kind, queries, output);
            break;
        case feature_spheres:
            run_on_bvh2<feature_spheres>(scene, kind, queries, output);
            break;
        default:
            run_on_bvh2<feature_triangles | feature_spheres>(scene, kind, queries, output);
    }
    return output;
}

}  // namespace haste
