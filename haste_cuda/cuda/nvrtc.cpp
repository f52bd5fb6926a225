#include "cuda/nvrtc.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <mutex>

#include "cuda/driver_api.h"
#include "cuda/shared_library.h"
#include "host/stopwatch.h"

namespace haste::cuda {

namespace {

using nvrtcResult = int;
using nvrtcProgram = struct nvrtcProgram_st*;
constexpr nvrtcResult nvrtc_success = 0;
constexpr int oldest_version = 12000;
constexpr int first_version_with_a_cache = 12090;

/// NVRTC's entry points.
struct Compiler {
    const char* (*get_error_string)(nvrtcResult);
    nvrtcResult (*get_version)(int* major, int* minor);
    nvrtcResult (*count_architectures)(int* count);
    nvrtcResult (*list_architectures)(int* architectures);
    nvrtcResult (*create_program)(nvrtcProgram*, const char* source, const char* name,
                                  int header_count, const char* const* headers,
                                  const char* const* include_names);
    nvrtcResult (*destroy_program)(nvrtcProgram*);
    nvrtcResult (*compile_program)(nvrtcProgram, int option_count, const char* const* options);
    nvrtcResult (*get_log_size)(nvrtcProgram, std::size_t* bytes);
    nvrtcResult (*get_log)(nvrtcProgram, char* log);
    nvrtcResult (*get_cubin_size)(nvrtcProgram, std::size_t* bytes);
    nvrtcResult (*get_cubin)(nvrtcProgram, char* cubin);

    int version = 0;
    std::string path;
    std::optional<std::string> unavailable;
};

struct Candidates {
    std::mutex mutex;
    std::vector<NvrtcCandidate> list;
    bool used = false;
};

Candidates& candidates() {
    static Candidates shared;
    return shared;
}

/// NVRTC 13.0 looks for its built-in functions on the system's path only; wheels have them beside
/// it. Loaded first, they are found by their name. Where there is no such file, NVRTC finds its
/// own.
void load_builtins(const std::string& path, int version) {
    const std::string name = "libnvrtc-builtins.so." + std::to_string(version / 1000) + "." +
                             std::to_string(version % 1000 / 10);
    std::string unused;
    (void)SharedLibrary::load(path.substr(0, path.rfind('/') + 1) + name, unused);
}

Compiler load_compiler(const std::string& path) {
    Compiler compiler{};
    compiler.path = path;
    std::string reason;
    const std::optional<SharedLibrary> library = SharedLibrary::load(path, reason);
    if (!library) {
        compiler.unavailable = reason;
        return compiler;
    }
    const auto find = [&](const char* name, auto& function) {
        if (!library->find(name, function) && !compiler.unavailable) {
            compiler.unavailable = path + " is too old: it has no " + name;
        }
    };
    find("nvrtcGetErrorString", compiler.get_error_string);
    find("nvrtcVersion", compiler.get_version);
    find("nvrtcGetNumSupportedArchs", compiler.count_architectures);
    find("nvrtcGetSupportedArchs", compiler.list_architectures);
    find("nvrtcCreateProgram", compiler.create_program);
    find("nvrtcDestroyProgram", compiler.destroy_program);
    find("nvrtcCompileProgram", compiler.compile_program);
    find("nvrtcGetProgramLogSize", compiler.get_log_size);
    find("nvrtcGetProgramLog", compiler.get_log);
    find("nvrtcGetCUBINSize", compiler.get_cubin_size);
    find("nvrtcGetCUBIN", compiler.get_cubin);
    if (compiler.unavailable) {
        return compiler;
    }
    int major = 0;
    int minor = 0;
    if (compiler.get_version(&major, &minor) != nvrtc_success) {
        compiler.unavailable = path + " does not tell its version";
        return compiler;
    }
    compiler.version = 1000 * major + 10 * minor;
    load_builtins(path, compiler.version);
    if (compiler.version < oldest_version) {
        compiler.unavailable = path + " is of CUDA " + version_text(compiler.version) + "; " +
                               version_text(oldest_version) + " or newer is needed";
    }
    return compiler;
}

/// The first candidate that loads and whose programs the driver can load; without a driver,
/// programs are only compiled and looked at.
Compiler choose_compiler(const std::vector<NvrtcCandidate>& list) {
    const std::optional<int> driver = driver_version();
    std::string tried;
    for (const NvrtcCandidate& candidate : list) {
        if (driver && candidate.major > *driver / 1000) {
            tried +=
                "; " + candidate.path + " is too new for a driver of CUDA " + version_text(*driver);
            continue;
        }
        Compiler compiler = load_compiler(candidate.path);
        if (!compiler.unavailable) {
            return compiler;
        }
        tried += "; " + *compiler.unavailable;
    }
    Compiler none{};
    none.unavailable = "NVRTC was not found, install it with: pip install ";
    *none.unavailable += driver && *driver < 13000 ? "nvidia-cuda-nvrtc-cu12" : "nvidia-cuda-nvrtc";
    *none.unavailable += tried.empty() ? "; nowhere to look was given" : tried;
    return none;
}

const Compiler& loaded_compiler() {
    static const Compiler compiler = [] {
        Candidates& shared = candidates();
        const std::lock_guard lock(shared.mutex);
        shared.used = true;
        return choose_compiler(shared.list);
    }();
    return compiler;
}

const Compiler& usable_compiler() {
    const Compiler& compiler = loaded_compiler();
    if (compiler.unavailable) {
        throw CompileError(*compiler.unavailable);
    }
    return compiler;
}

void require(nvrtcResult result, const Compiler& compiler, const char* call,
             const std::string& name) {
    if (result != nvrtc_success) {
        throw CompileError(std::string(call) + " failed for " + name + ": " +
                           compiler.get_error_string(result));
    }
}

/// The number that stands in front of `unit`, or 0.
int number_before(std::string_view line, std::string_view unit) {
    const std::size_t end = line.find(unit);
    if (end == std::string_view::npos) {
        return 0;
    }
    const std::size_t before = line.find_last_not_of("0123456789", end - 1);
    int number = 0;
    for (std::size_t i = before + 1; i < end; ++i) {
        number = 10 * number + (line[i] - '0');
    }
    return number;
}

}  // namespace

void set_nvrtc_candidates(std::vector<NvrtcCandidate> list) {
    Candidates& shared = candidates();
    const std::lock_guard lock(shared.mutex);
    if (shared.used && list != shared.list) {
        throw std::logic_error("NVRTC is already in use, another one cannot be chosen");
    }
    shared.list = std::move(list);
}

std::optional<std::string> nvrtc_unavailable() { return loaded_compiler().unavailable; }

int nvrtc_version() { return usable_compiler().version; }

std::string nvrtc_path() { return usable_compiler().path; }

std::vector<int> nvrtc_architectures() {
    const Compiler& compiler = usable_compiler();
    int count = 0;
    require(compiler.count_architectures(&count), compiler, "nvrtcGetNumSupportedArchs", "NVRTC");
    std::vector<int> architectures(static_cast<std::size_t>(count));
    require(compiler.list_architectures(architectures.data()), compiler, "nvrtcGetSupportedArchs",
            "NVRTC");
    std::ranges::sort(architectures);
    return architectures;
}

int architecture_for(int compute_capability_major, int compute_capability_minor) {
    const int device = 10 * compute_capability_major + compute_capability_minor;
    int best = 0;
    for (const int architecture : nvrtc_architectures()) {
        if (architecture / 10 == compute_capability_major && architecture <= device) {
            best = architecture;
        }
    }
    if (best == 0) {
        throw CompileError("NVRTC of CUDA " + version_text(nvrtc_version()) +
                           " cannot compile for a GPU of compute capability " +
                           std::to_string(compute_capability_major) + "." +
                           std::to_string(compute_capability_minor));
    }
    return best;
}

std::vector<std::string> compiler_options(const Translation& translation) {
    std::vector<std::string> options{
        "--gpu-architecture=sm_" + std::to_string(translation.architecture), "--std=c++20",
        "--generate-line-info", "--ptxas-options=-v"};
    if (usable_compiler().version >= first_version_with_a_cache) {
        options.push_back("--no-cache");  // compile_seconds must be the time of a first compilation
    }
    options.insert(options.end(), translation.options.begin(), translation.options.end());
    return options;
}

Program compile(const Translation& translation) {
    const Compiler& compiler = usable_compiler();
    nvrtcProgram handle = nullptr;
    require(compiler.create_program(&handle, translation.source.c_str(), translation.name.c_str(),
                                    0, nullptr, nullptr),
            compiler, "nvrtcCreateProgram", translation.name);
    const auto destroy = [&](nvrtcProgram* program) { compiler.destroy_program(program); };
    const std::unique_ptr<nvrtcProgram, decltype(destroy)> owner(&handle, destroy);

    std::vector<std::string> options = compiler_options(translation);
    if (!translation.include_root.empty()) {
        options.push_back("--include-path=" + translation.include_root.string());
    }
    std::vector<const char*> pointers;
    std::string spelled;
    for (const std::string& option : options) {
        pointers.push_back(option.c_str());
        spelled += " " + option;
    }
    const Stopwatch watch;
    const nvrtcResult result =
        compiler.compile_program(handle, static_cast<int>(pointers.size()), pointers.data());
    Program program;
    program.compile_seconds = watch.seconds();

    std::size_t size = 0;
    require(compiler.get_log_size(handle, &size), compiler, "nvrtcGetProgramLogSize",
            translation.name);
    program.log.resize(size);
    require(compiler.get_log(handle, program.log.data()), compiler, "nvrtcGetProgramLog",
            translation.name);
    program.log.resize(program.log.find_last_not_of(std::string_view("\0\n", 2)) + 1);
    if (result != nvrtc_success) {
        throw CompileError(translation.name +
                           " does not compile: " + compiler.get_error_string(result) + ", options" +
                           spelled + "\n" + program.log);
    }
    require(compiler.get_cubin_size(handle, &size), compiler, "nvrtcGetCUBINSize",
            translation.name);
    program.cubin.resize(size);
    require(compiler.get_cubin(handle, program.cubin.data()), compiler, "nvrtcGetCUBIN",
            translation.name);
    program.resources = parse_resources(program.log);
    return program;
}

std::vector<KernelResources> parse_resources(std::string_view log) {
    constexpr std::string_view entry = "Compiling entry function '";
    std::vector<KernelResources> kernels;
    while (!log.empty()) {
        const std::size_t end = std::min(log.find('\n'), log.size());
        const std::string_view line = log.substr(0, end);
        log.remove_prefix(std::min(end + 1, log.size()));
        if (const std::size_t at = line.find(entry); at != std::string_view::npos) {
            const std::string_view rest = line.substr(at + entry.size());
            kernels.push_back({.kernel = std::string(rest.substr(0, rest.find('\'')))});
        } else if (!kernels.empty() && line.find("bytes stack frame") != std::string_view::npos) {
            KernelResources& kernel = kernels.back();
            kernel.stack_bytes =
                std::max(kernel.stack_bytes, number_before(line, " bytes stack frame"));
            kernel.spill_store_bytes += number_before(line, " bytes spill stores");
            kernel.spill_load_bytes += number_before(line, " bytes spill loads");
        } else if (!kernels.empty() && line.find(" registers") != std::string_view::npos) {
            KernelResources& kernel = kernels.back();
            kernel.registers = number_before(line, " registers");
            kernel.shared_bytes = number_before(line, " bytes smem");
            kernel.stack_bytes =
                std::max(kernel.stack_bytes, number_before(line, " bytes cumulative stack size"));
        }
    }
    return kernels;
}

}  // namespace haste::cuda
