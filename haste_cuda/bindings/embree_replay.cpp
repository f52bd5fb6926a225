#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "bindings/bindings.h"
#include "reference/embree/embree_packets.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace haste {

namespace {

/// Origin, t_min, direction and t_max of a ray, as `RayQuery` has them.
using RayTable = nb::ndarray<const float, nb::shape<-1, 8>, nb::c_contig, nb::device::cpu>;
static_assert(sizeof(RayQuery<float>) == 8 * sizeof(float));

EmbreeMode mode_of(const std::string& name) {
    if (name == "robust") return EmbreeMode::robust;
    if (name == "fast") return EmbreeMode::fast;
    throw std::invalid_argument("mode must be one of fast, robust, not " + name);
}

template <class T>
nb::ndarray<nb::numpy, T> to_numpy(std::vector<T> values) {
    auto* data = new std::vector<T>(std::move(values));
    const nb::capsule owner(data, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nb::ndarray<nb::numpy, T>(data->data(), {data->size()}, owner);
}

nb::dict trace_on_embree(SceneHandle& handle, const RayTable& rays, bool any_hit, int width,
                         const std::string& mode_name, int threads, int repeats) {
    const EmbreeMode mode = mode_of(mode_name);
    const std::span queries(reinterpret_cast<const RayQuery<float>*>(rays.data()), rays.shape(0));
    const EmbreeScene* scene = nullptr;
    EmbreeReplay output;
    std::vector<float> t;
    std::vector<u32> primitive;
    {
        const nb::gil_scoped_release release;
        scene = &handle.embree(mode);
        output = replay_embree(*scene, queries, any_hit ? QueryKind::any_hit : QueryKind::closest,
                               {width, threads, repeats});
        t.reserve(output.hits.size());
        primitive.reserve(output.hits.size());
        for (const QueryHit<float>& hit : output.hits) {
            t.push_back(hit.t);
            primitive.push_back(hit.primitive);
        }
    }
    nb::dict result;
    result["t"] = to_numpy(std::move(t));
    result["primitive"] = to_numpy(std::move(primitive));
    result["seconds"] = output.seconds;
    result["build_seconds"] = scene->build_seconds();
    result["bytes"] = scene->bytes();
    return result;
}

}  // namespace

void bind_embree_replay(nb::module_& module) {
    module.def(
        "trace_embree", &trace_on_embree, "scene"_a, "rays"_a, nb::kw_only(), "any_hit"_a = false,
        "width"_a = 1, "mode"_a = "robust", "threads"_a = 0, "repeats"_a = 1,
        "Traces rays through Embree's scene of a mode (robust or fast), width (1, 8 or 16) "
        "rays a call. rays: float32 [n, 8], origin, t_min, direction and t_max of each. "
        "Returns a dict: t and primitive as of trace_cpu, seconds (of each repeat), "
        "build_seconds and bytes of Embree's hierarchy. Raises ValueError naming the ray, or "
        "why Embree has no such packets.");
}

}  // namespace haste
