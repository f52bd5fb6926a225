#include "cuda/bindings_cuda.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <span>
#include <utility>

#include "accel/sha256.h"
#include "cuda/availability.h"
#include "cuda/check.h"
#include "cuda/copy_rates.h"
#include "cuda/cubin_cache.h"
#include "cuda/device.h"
#include "cuda/kernel_source.h"
#include "cuda/nvrtc.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace haste::cuda {

namespace {

nb::dict device_info(int ordinal) {
    const DeviceInfo info = query_device(ordinal);
    nb::dict result;
    result["name"] = info.name;
    result["uuid"] = info.uuid;
    result["compute_capability"] =
        nb::make_tuple(info.compute_capability_major, info.compute_capability_minor);
    result["multiprocessors"] = info.multiprocessors;
    result["memory_bytes"] = info.memory_bytes;
    result["l2_cache_bytes"] = info.l2_cache_bytes;
    result["clock_khz"] = info.clock_khz;
    result["memory_clock_khz"] = info.memory_clock_khz;
    result["max_threads_per_block"] = info.max_threads_per_block;
    result["max_threads_per_multiprocessor"] = info.max_threads_per_multiprocessor;
    result["max_shared_memory_per_block"] = info.max_shared_memory_per_block;
    result["driver_version"] = version_text(info.driver_version);
    return result;
}

nb::dict copy_rates(std::size_t bytes, int repeats) {
    const CopyRates rates = measure_copies(bytes, repeats);
    nb::dict result;
    result["pinned_up"] = rates.pinned_up;
    result["pinned_down"] = rates.pinned_down;
    result["pinned_both"] = rates.pinned_both;
    result["pageable_up"] = rates.pageable_up;
    result["pageable_down"] = rates.pageable_down;
    result["device"] = rates.device;
    return result;
}

nb::dict describe(const CachedProgram& compiled) {
    nb::dict kernels;
    for (const KernelResources& resources : compiled.program.resources) {
        nb::dict entry;
        entry["registers"] = resources.registers;
        entry["stack_bytes"] = resources.stack_bytes;
        entry["spill_store_bytes"] = resources.spill_store_bytes;
        entry["spill_load_bytes"] = resources.spill_load_bytes;
        entry["shared_bytes"] = resources.shared_bytes;
        kernels[resources.kernel.c_str()] = entry;
    }
    nb::dict result;
    result["kernels"] = kernels;
    result["log"] = compiled.program.log;
    result["cubin"] = nb::bytes(compiled.program.cubin.data(), compiled.program.cubin.size());
    result["compile_seconds"] = compiled.program.compile_seconds;
    result["seconds"] = compiled.seconds;
    result["cached"] = compiled.cached;
    result["cache_problem"] = compiled.cache_problem;
    return result;
}

nb::dict build(const Translation& translation, bool use_cache) {
    CachedProgram compiled;
    {
        const nb::gil_scoped_release release;
        if (use_cache) {
            compiled = load_or_compile(translation, CubinCache::standard());
        } else {
            compiled.program = compile(translation);
            compiled.seconds = compiled.program.compile_seconds;
        }
    }
    return describe(compiled);
}

Translation translation_of(const std::string& source, int architecture,
                           const std::vector<std::string>& options, const std::string& name) {
    return {.source = source,
            .name = name,
            .include_root = include_root(),
            .architecture = architecture,
            .options = options};
}

KernelSpecification specification_of(const std::string& kernel, const std::string& model,
                                     const std::string& precision, std::uint32_t features,
                                     int stack_capacity, const std::string& film, bool layered,
                                     bool count_rays, const std::string& traversal) {
    return {.kernel = kernel,
            .model = model,
            .precision = precision,
            .features = features,
            .traversal = traversal,
            .stack_capacity = stack_capacity,
            .film = film,
            .layered = layered,
            .count_rays = count_rays};
}

void bind_availability(nb::module_& module) {
    module.def("cuda_unavailable", &cuda_unavailable,
               "Why haste-cuda cannot run here (driver, device, NVRTC), or None.");
    module.def("driver_unavailable", &driver_unavailable,
               "Why the CUDA driver cannot be used (library, version, device), or None.");
    module.def("nvrtc_unavailable", &nvrtc_unavailable,
               "Why the compiler NVRTC cannot be used, or None.");
    module.def("driver_version", &driver_version,
               "Newest CUDA version that the driver supports, 1000 * major + 10 * minor, or None.");
    module.def(
        "device_info", &device_info, "ordinal"_a = 0,
        "Name, uuid, compute capability, sizes (bytes), clocks (kHz) and driver version of a "
        "GPU. Raises CudaError without one.");
    module.def("copy_rates", &copy_rates, "bytes"_a, "repeats"_a = 5,
               "Measures copies of so many bytes; bytes a second, the fastest of the repeats: "
               "pinned_up, pinned_down, pinned_both (each way, both at once), pageable_up, "
               "pageable_down, device (read and written). Raises CudaError.");
}

void bind_compiler(nb::module_& module) {
    module.def(
        "set_nvrtc_candidates",
        [](const std::vector<std::pair<int, std::string>>& candidates) {
            std::vector<NvrtcCandidate> list;
            for (const auto& [major, path] : candidates) list.push_back({major, path});
            set_nvrtc_candidates(std::move(list));
        },
        "candidates"_a,
        "Names places where NVRTC may be, (major version, path), best first, before its first "
        "use.");
    module.def(
        "set_include_root", [](const std::string& root) { set_include_root(root); }, "root"_a,
        "Names the folder that holds core/ and cuda/kernels/.");
    module.def("nvrtc_version", &nvrtc_version,
               "Version of NVRTC, 1000 * major + 10 * minor. Raises CompileError without it.");
    module.def("nvrtc_path", &nvrtc_path,
               "The NVRTC library in use. Raises CompileError without it.");
    module.def("nvrtc_architectures", &nvrtc_architectures,
               "Architectures NVRTC can compile for, 10 * major + minor, ascending.");
    module.def("kernel_names", &kernel_names, "The kernels of the engines.");
    module.def("kernel_models", &kernel_models, "Models that have kernels.");
    module.def("kernel_precisions", &kernel_precisions, "Precisions that have kernels.");
    module.def("kernel_films", &kernel_films, "Films that have kernels.");
    module.def(
        "kernel_source",
        [](const std::string& kernel, const std::string& model, const std::string& precision,
           std::uint32_t features, int stack_capacity, const std::string& film, bool layered,
           bool count_rays, const std::string& traversal) {
            return kernel_source(specification_of(kernel, model, precision, features,
                                                  stack_capacity, film, layered, count_rays,
                                                  traversal));
        },
        "kernel"_a, "model"_a, "precision"_a, "features"_a, "stack_capacity"_a = 1,
        "film"_a = "int64", "layered"_a = false, "count_rays"_a = false,
        "traversal"_a = name_of(default_traversal),
        "The translation unit of a kernel. Raises ValueError naming what is unknown.");
    module.def(
        "compile_kernel",
        [](const std::string& kernel, const std::string& model, const std::string& precision,
           std::uint32_t features, int stack_capacity, const std::string& film, bool layered,
           bool count_rays, const std::string& traversal, int architecture, bool use_cache) {
            const KernelSpecification specification =
                specification_of(kernel, model, precision, features, stack_capacity, film, layered,
                                 count_rays, traversal);
            return build(kernel_translation(specification, architecture), use_cache);
        },
        "kernel"_a, "model"_a, "precision"_a, "features"_a, "stack_capacity"_a = 1,
        "film"_a = "int64", "layered"_a = false, "count_rays"_a = false,
        "traversal"_a = name_of(default_traversal), nb::kw_only(), "architecture"_a,
        "use_cache"_a = true,
        "Compiles a kernel for an architecture (90 is sm_90); no GPU is needed. See "
        "compile_source.");
    module.def(
        "compile_replay_kernel",
        [](bool any_hit, const std::string& precision, std::uint32_t features,
           const std::string& traversal, bool count, int architecture, bool use_cache) {
            return build(kernel_translation(ReplaySpecification{.any_hit = any_hit,
                                                                .traversal = traversal,
                                                                .count = count,
                                                                .precision = precision,
                                                                .features = features},
                                            architecture),
                         use_cache);
        },
        "any_hit"_a, "precision"_a, "features"_a, "traversal"_a = name_of(default_traversal),
        "count"_a = false, nb::kw_only(), "architecture"_a, "use_cache"_a = true,
        "Compiles the kernel that replays rays, for closest hits or for any hit. See "
        "compile_source.");
    module.def(
        "compile_source",
        [](const std::string& source, int architecture, const std::vector<std::string>& options,
           const std::string& name, bool use_cache) {
            return build(translation_of(source, architecture, options, name), use_cache);
        },
        "source"_a, "architecture"_a, "options"_a = std::vector<std::string>(),
        "name"_a = "source.cu", "use_cache"_a = true,
        "Compiles CUDA C++. Returns kernels (name -> registers, stack_bytes, spill_store_bytes, "
        "spill_load_bytes, shared_bytes), log, cubin, compile_seconds (time in NVRTC, when it was "
        "compiled), seconds (now), cached, cache_problem. Raises CompileError with the log.");
}

void bind_cache(nb::module_& module) {
    module.def(
        "cubin_cache_directory", [] { return CubinCache::standard().directory().string(); },
        "The folder of the compiled kernels.");
    module.def(
        "cubin_cache_file",
        [](const std::string& source, int architecture, const std::vector<std::string>& options,
           const std::string& name) {
            const Translation translation = translation_of(source, architecture, options, name);
            return CubinCache::standard().file(cache_key(translation)).string();
        },
        "source"_a, "architecture"_a, "options"_a = std::vector<std::string>(),
        "name"_a = "source.cu", "The file that holds, or would hold, the compiled source.");
    module.def(
        "sha256",
        [](nb::bytes bytes) {
            const std::span view(static_cast<const std::byte*>(bytes.data()), bytes.size());
            return sha256_hex(view);
        },
        "data"_a, "SHA-256 of the bytes, in hexadecimal.");
}

}  // namespace

void bind_cuda(nb::module_& module) {
    nb::exception<CudaError>(module, "CudaError", PyExc_RuntimeError);
    nb::exception<CompileError>(module, "CompileError", PyExc_RuntimeError);
    bind_availability(module);
    bind_compiler(module);
    bind_cache(module);
}

}  // namespace haste::cuda
