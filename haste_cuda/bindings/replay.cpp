#include "cpu/replay.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>

#include "bindings/arrays.h"
#include "bindings/bindings.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace haste {

TraversalKind traversal_of(const std::string& name) {
    std::string known;
    for (u32 i = 0; i < traversal_count; ++i) {
        if (name == traversal_names[i]) return TraversalKind(i);
        known += std::string(i == 0 ? "" : ", ") + traversal_names[i];
    }
    throw std::invalid_argument("traversal must be one of " + known + ", not " + name);
}

PrecisionKind precision_of(const std::string& name) {
    std::string known;
    for (u32 i = 0; i < precision_count; ++i) {
        if (name == precision_names[i]) return PrecisionKind(i);
        known += std::string(i == 0 ? "" : ", ") + precision_names[i];
    }
    throw std::invalid_argument("precision must be one of " + known + ", not " + name);
}

namespace {

std::vector<RayQuery<float>> make_queries(const Points& origins, const Points& directions,
                                          const Reals& t_min, const Reals& t_max) {
    const std::size_t n = origins.shape(0);
    if (directions.shape(0) != n || t_min.size() != n || t_max.size() != n) {
        throw std::invalid_argument(
            "origins, directions, t_min and t_max must have one entry a ray, not " +
            std::to_string(n) + ", " + std::to_string(directions.shape(0)) + ", " +
            std::to_string(t_min.size()) + " and " + std::to_string(t_max.size()));
    }
    std::vector<RayQuery<float>> queries(n);
    for (std::size_t i = 0; i < n; ++i) {
        queries[i] = {point(origins, i), t_min(i), point(directions, i), t_max(i)};
    }
    return queries;
}

nb::dict to_dict(const ReplayOutput& output) {
    const std::size_t n = output.hits.size();
    std::vector<float> t;
    std::vector<u32> primitive;
    t.reserve(n);
    primitive.reserve(n);
    for (const QueryHit<float>& hit : output.hits) {
        t.push_back(hit.t);
        primitive.push_back(hit.primitive);
    }
    nb::dict result;
    result["t"] = to_numpy(std::move(t), {n});
    result["primitive"] = to_numpy(std::move(primitive), {n});
    result["seconds"] = output.seconds;
    if (output.visited) {
        const double rays = double(std::max<std::size_t>(output.hits.size(), 1));
        result["nodes"] = double(output.visited->nodes) / rays;
        result["triangles"] = double(output.visited->primitives) / rays;
    }
    return result;
}

BvhInfo bvh_of(SceneHandle& scene, const std::string& traversal) {
    const TraversalKind kind = traversal_of(traversal);
    const nb::gil_scoped_release release;
    return scene.host().bvh(kind);
}

QueryKind query_kind(bool any_hit) { return any_hit ? QueryKind::any_hit : QueryKind::closest; }

nb::dict trace_on_cpu(SceneHandle& scene, const Points& origins, const Points& directions,
                      const Reals& t_min, const Reals& t_max, bool any_hit,
                      const std::string& intersector, const std::string& traversal,
                      const std::string& precision, int threads, int repeats, bool count) {
    if (intersector != "haste" && intersector != "embree") {
        throw std::invalid_argument("intersector must be one of embree, haste, not " + intersector);
    }
    const std::vector<RayQuery<float>> queries = make_queries(origins, directions, t_min, t_max);
    const ReplaySchedule schedule{
        intersector == "embree" ? IntersectorKind::embree : IntersectorKind::haste,
        traversal_of(traversal),
        precision_of(precision),
        threads,
        repeats,
        count};
    ReplayOutput output;
    {
        const nb::gil_scoped_release release;
        output =
            replay_cpu(scene.host(), queries, query_kind(any_hit), schedule,
                       schedule.intersector == IntersectorKind::embree ? &scene.embree() : nullptr);
    }
    return to_dict(output);
}

nb::dict trace_on_cuda(SceneHandle& scene, const Points& origins, const Points& directions,
                       const Reals& t_min, const Reals& t_max, bool any_hit,
                       const std::string& traversal, const std::string& precision, int block,
                       int repeats, bool count) {
    const std::vector<RayQuery<float>> queries = make_queries(origins, directions, t_min, t_max);
    const cuda::CudaReplaySchedule schedule{traversal_of(traversal), precision_of(precision), block,
                                            repeats, count};
    cuda::CudaReplayOutput output;
    {
        const nb::gil_scoped_release release;
        output = cuda::Renderer::instance().replay(scene.host(), scene.device(), queries,
                                                   query_kind(any_hit), schedule);
    }
    nb::dict result = to_dict(output.replay);
    result["compile_seconds"] = output.compile_seconds;
    result["scene_upload_seconds"] = output.scene_upload_seconds;
    result["upload_seconds"] = output.upload_seconds;
    result["download_seconds"] = output.download_seconds;
    result["registers"] = output.registers;
    return result;
}

}  // namespace

void bind_replay(nb::module_& module) {
    module.def(
        "traversals",
        [] { return std::vector<std::string>(traversal_names, traversal_names + traversal_count); },
        "Names of the ways to find what a ray hits. All find the same.");
    module.def(
        "default_traversal", [] { return std::string(name_of(default_traversal)); },
        "The traversal of images, and of replays that name none.");
    module.def(
        "bvh_bytes",
        [](SceneHandle& scene, const std::string& traversal) {
            return bvh_of(scene, traversal).bytes;
        },
        "scene"_a, "traversal"_a,
        "Bytes of what a traversal reads, nodes and primitives; builds it on first use.");
    module.def(
        "bvh_build_seconds",
        [](SceneHandle& scene, const std::string& traversal) {
            return bvh_of(scene, traversal).build_seconds;
        },
        "scene"_a, "traversal"_a,
        "Seconds that building the hierarchy of a traversal took; builds it on first use.");
    module.def(
        "trace_cpu", &trace_on_cpu, "scene"_a, "origins"_a, "directions"_a, "t_min"_a, "t_max"_a,
        nb::kw_only(), "any_hit"_a = false, "intersector"_a = "haste",
        "traversal"_a = name_of(default_traversal), "precision"_a = "watertight", "threads"_a = 0,
        "repeats"_a = 1, "count"_a = false,
        "Traces rays for their own sake. Arrays: origins and directions float32 [n, 3], "
        "t_min and t_max float32 [n]. Returns a dict: t (float32 [n], infinity without a "
        "hit within (t_min, t_max]), primitive (uint32 [n], triangles from 0, spheres after "
        "them, 0xffffffff without a hit), seconds (list, tracing alone, one a repeat). With "
        "any_hit t is 0 where something is hit, and primitive is not known. With count also nodes "
        "and triangles, visited a ray in the mean. Raises ValueError naming the ray.");
    module.def("trace_cuda", &trace_on_cuda, "scene"_a, "origins"_a, "directions"_a, "t_min"_a,
               "t_max"_a, nb::kw_only(), "any_hit"_a = false,
               "traversal"_a = name_of(default_traversal), "precision"_a = "watertight",
               "block"_a = 128, "repeats"_a = 1, "count"_a = false,
               "The same on the GPU. Returns the dict of trace_cpu (seconds of "
               "the kernel, by the device's clock) with compile_seconds, scene_upload_seconds, "
               "upload_seconds and download_seconds (rays and hits), registers. Raises CudaError "
               "and ValueError.");
}

}  // namespace haste
