#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>

#include "bindings/bindings.h"
#include "bindings/build_info.h"
#include "cuda/bindings_cuda.h"

NB_MODULE(_core, module) {
    module.doc() = "The compiled half of haste_cuda: scenes, engines and the CUDA layer.";
    module.def(
        "build_info", &haste::build_info,
        "How the extension was compiled: a dict of strings, for a measurement's provenance.");
    haste::bind_scene(module);
    haste::bind_render(module);
    haste::bind_replay(module);
    haste::bind_embree_replay(module);
    haste::bind_testing(module);
    haste::cuda::bind_cuda(module);
}
