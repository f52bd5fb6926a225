#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace haste::cuda {

/// What ptxas says about one kernel.
struct KernelResources {
    std::string kernel;
    int registers = 0;
    int stack_bytes = 0;  ///< local memory of a thread, calls included
    int spill_store_bytes = 0;
    int spill_load_bytes = 0;
    int shared_bytes = 0;  ///< static shared memory of a block
};

/// A compiled translation unit.
struct Program {
    std::string cubin;                       ///< an ELF image, for cuModuleLoadData
    std::string log;                         ///< warnings and ptxas's resource usage
    std::vector<KernelResources> resources;  ///< read from the log, one a kernel
    double compile_seconds = 0;              ///< time in NVRTC, also where it came from the cache
};

/// A translation unit that does not compile. The message is the compiler's whole log.
class CompileError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// What to compile, and how. Everything here decides the result, so everything is part of the key
/// of the cubin cache: of the include directory its headers' contents, not its path.
struct Translation {
    std::string source;
    std::string name;                    ///< the file name in error messages
    std::filesystem::path include_root;  ///< may be empty: then nothing can be included
    int architecture = 0;                ///< 10 * major + minor of the compute capability: 90
    std::vector<std::string> options;    ///< besides those that every program gets
};

/// All options but the include directory: those that every program gets, then the translation's.
/// Throws CompileError without NVRTC.
[[nodiscard]] std::vector<std::string> compiler_options(const Translation& translation);

/// A place where NVRTC may be.
struct NvrtcCandidate {
    int major = 0;     ///< major version of CUDA
    std::string path;  ///< a file, or a name that the dynamic linker searches

    bool operator==(const NvrtcCandidate&) const = default;
};

/// Names the places to try, best first. At the first use of NVRTC the first one is taken that loads
/// and is not of a newer major version than the driver, whose programs the driver could not load.
/// Throws std::logic_error if other places are named after that.
void set_nvrtc_candidates(std::vector<NvrtcCandidate> candidates);

/// Why NVRTC cannot be used and what to install, or nothing. Loads the library.
[[nodiscard]] std::optional<std::string> nvrtc_unavailable();

/// 1000 * major + 10 * minor, as the driver writes it. Throws CompileError without NVRTC.
[[nodiscard]] int nvrtc_version();

/// The candidate in use. Throws CompileError without NVRTC.
[[nodiscard]] std::string nvrtc_path();

/// The architectures NVRTC can compile for, ascending: 75, 80, ... Throws CompileError without
/// NVRTC.
[[nodiscard]] std::vector<int> nvrtc_architectures();

/// The newest architecture whose cubins run on a GPU of this compute capability: the same major
/// version, at most its minor version. Throws CompileError if NVRTC knows none.
[[nodiscard]] int architecture_for(int compute_capability_major, int compute_capability_minor);

/// Compiles with NVRTC, in C++20, with line information for profilers and debuggers. Takes seconds,
/// needs no GPU. Throws CompileError.
[[nodiscard]] Program compile(const Translation& translation);

/// Reads what `--ptxas-options=-v` wrote into a log. Spills of functions that were not inlined are
/// added to the kernel that calls them.
[[nodiscard]] std::vector<KernelResources> parse_resources(std::string_view log);

}  // namespace haste::cuda
