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

void add_hits(nb::dict& result, std::span<const QueryHit<float>> hits) {
    std::vector<float> t;
    std::vector<u32> primitive;
    t.reserve(hits.size());
    primitive.reserve(hits.size());
    for (const QueryHit<float>& hit : hits) {
        t.push_back(hit.t);
        primitive.push_back(hit.primitive);
    }
    result["t"] = to_numpy(std::move(t), {hits.size()});
    result["primitive"] = to_numpy(std::move(primitive), {hits.size()});
}

namespace {

RaysHandle make_rays(const Points& origins, const Points& directions, const Reals& t_min,
                     const Reals& t_max) {
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
    return RaysHandle(std::move(queries));
}

nb::dict to_dict(const ReplayOutput& output, std::size_t rays, bool hits) {
    nb::dict result;
    if (hits) add_hits(result, output.hits);
    result["seconds"] = output.seconds;
    if (output.visited) {
        const double count = double(std::max<std::size_t>(rays, 1));
        result["nodes"] = double(output.visited->nodes) / count;
        result["triangles"] = double(output.visited->primitives) / count;
    }
    return result;
}

BvhInfo bvh_of(SceneHandle& scene, const std::string& traversal) {
    const TraversalKind kind = traversal_of(traversal);
    const nb::gil_scoped_release release;
    return scene.host().bvh(kind);
}

QueryKind query_kind(bool any_hit) { return any_hit ? QueryKind::any_hit : QueryKind::closest; }

nb::dict trace_on_cpu(SceneHandle& scene, const RaysHandle& rays, bool any_hit,
                      const std::string& intersector, const std::string& traversal,
                      const std::string& precision, int threads, int repeats, bool count,
                      bool hits) {
    if (intersector != "haste" && intersector != "embree") {
        throw std::invalid_argument("intersector must be one of embree, haste, not " + intersector);
    }
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
            replay_cpu(scene.host(), rays.host(), query_kind(any_hit), schedule,
                       schedule.intersector == IntersectorKind::embree ? &scene.embree() : nullptr);
    }
    return to_dict(output, rays.size(), hits);
}

nb::dict trace_on_cuda(SceneHandle& scene, RaysHandle& rays, bool any_hit,
                       const std::string& traversal, const std::string& precision, int block,
                       int repeats, bool count, bool hits) {
    const cuda::CudaReplaySchedule schedule{
        traversal_of(traversal), precision_of(precision), block, repeats, count, hits};
    cuda::CudaReplayOutput output;
    {
        const nb::gil_scoped_release release;
        output = cuda::Renderer::instance().replay(scene.host(), scene.device(), rays.host(),
                                                   rays.device(), query_kind(any_hit), schedule);
    }
    nb::dict result = to_dict(output.replay, rays.size(), hits);
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
    nb::class_<RaysHandle>(module, "Rays",
                           "Rays that are checked once and held for any number of replays, on a "
                           "GPU too once they are traced there. Arrays: origins and directions "
                           "float32 [n, 3], t_min and t_max float32 [n]. Raises ValueError naming "
                           "the ray that makes no sense.")
        .def(nb::new_(&make_rays), "origins"_a, "directions"_a, "t_min"_a, "t_max"_a)
        .def("__len__", &RaysHandle::size);
    module.def(
        "trace_cpu", &trace_on_cpu, "scene"_a, "rays"_a, nb::kw_only(), "any_hit"_a = false,
        "intersector"_a = "haste", "traversal"_a = name_of(default_traversal),
        "precision"_a = "watertight", "threads"_a = 0, "repeats"_a = 1, "count"_a = false,
        "hits"_a = true,
        "Traces rays for their own sake. Returns a dict: t (float32 [n], infinity without a "
        "hit within (t_min, t_max]), primitive (uint32 [n], triangles from 0, spheres after "
        "them, 0xffffffff without a hit), seconds (list, tracing alone, one a repeat). With "
        "any_hit t is 0 where something is hit, and primitive is not known. With count also nodes "
        "and triangles, visited a ray in the mean. Without hits neither t nor primitive. Raises "
        "ValueError.");
    module.def("trace_cuda", &trace_on_cuda, "scene"_a, "rays"_a, nb::kw_only(),
               "any_hit"_a = false, "traversal"_a = name_of(default_traversal),
               "precision"_a = "watertight", "block"_a = 128, "repeats"_a = 1, "count"_a = false,
               "hits"_a = true,
               "The same on the GPU. Returns the dict of trace_cpu (seconds of "
               "the kernel, by the device's clock) with compile_seconds, scene_upload_seconds, "
               "upload_seconds and download_seconds (rays and hits), registers. Raises CudaError "
               "and ValueError.");
}

}  // namespace haste
