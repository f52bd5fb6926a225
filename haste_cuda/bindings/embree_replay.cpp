#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "bindings/bindings.h"
#include "reference/embree/embree_packets.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace haste {

namespace {

EmbreeMode mode_of(const std::string& name) {
    if (name == "robust") return EmbreeMode::robust;
    if (name == "fast") return EmbreeMode::fast;
    throw std::invalid_argument("mode must be one of fast, robust, not " + name);
}

nb::dict trace_on_embree(SceneHandle& handle, const RaysHandle& rays, bool any_hit, int width,
                         const std::string& mode_name, int threads, int repeats, bool hits) {
    const EmbreeMode mode = mode_of(mode_name);
    const EmbreeScene* scene = nullptr;
    EmbreeReplay output;
    {
        const nb::gil_scoped_release release;
        scene = &handle.embree(mode);
        output =
            replay_embree(*scene, rays.host(), any_hit ? QueryKind::any_hit : QueryKind::closest,
                          {width, threads, repeats});
    }
    nb::dict result;
    if (hits) add_hits(result, output.hits);
    result["seconds"] = output.seconds;
    result["build_seconds"] = scene->build_seconds();
    result["bytes"] = scene->bytes();
    return result;
}

}  // namespace

void bind_embree_replay(nb::module_& module) {
    module.def(
        "trace_embree", &trace_on_embree, "scene"_a, "rays"_a, nb::kw_only(), "any_hit"_a = false,
        "width"_a = 1, "mode"_a = "robust", "threads"_a = 0, "repeats"_a = 1, "hits"_a = true,
        "Traces rays through Embree's scene of a mode (robust or fast), width (1, 8 or 16) "
        "rays a call. Returns a dict: t and primitive as of trace_cpu, seconds (of each repeat), "
        "build_seconds and bytes of Embree's hierarchy. Raises ValueError saying why Embree has "
        "no such packets.");
}

}  // namespace haste
