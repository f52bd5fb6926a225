#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/traversal_kind.h"
#include "cuda/nvrtc.h"

namespace haste::cuda {

/// The function that every generated translation unit exports.
inline constexpr const char* kernel_entry = "haste_kernel";

/// Which of the core's templates a kernel instantiates. Names are those of the settings.
struct KernelSpecification {
    std::string kernel = "depth_first";
    std::string model;  ///< "haste", "whitted" or "path"
    std::string precision = "watertight";
    std::uint32_t features = 0;  ///< bits of haste::Features that the scene requires
    std::string traversal = name_of(default_traversal);
    int stack_capacity = 1;      ///< rays that a private stack holds
    std::string film = "int64";  ///< or "float_atomic"
    bool layered = false;        ///< a film a layer, weighted afterwards
    bool count_rays = false;

    /// "depth_first haste watertight features=0x3f bvh8 stack=12 film=int64 layered=0 count=0":
    /// names launches and errors.
    [[nodiscard]] std::string name() const;
};

/// Which of the core's templates a replay kernel instantiates. It shades nothing, so it knows of a
/// scene only which primitives it has.
struct ReplaySpecification {
    bool any_hit = false;
    std::string traversal = name_of(default_traversal);
    bool count = false;  ///< counts what is visited, one thread a ray
    std::string precision = "watertight";
    std::uint32_t features =
        0;  ///< of the scene; those that are not kinds of primitive are ignored

    /// "replay closest bvh8 watertight features=0x3 count=0": names launches and errors.
    [[nodiscard]] std::string name() const;

    /// Whether the kernel's warps are resident and take rays from a counter; else it has one thread
    /// a ray.
    [[nodiscard]] bool resident() const { return traversal == "bvh8" && !count; }
};

/// Names the folder that holds core/ and cuda/kernels/: where the kernels' headers are.
void set_include_root(const std::filesystem::path& root);

/// That folder. Throws std::logic_error if it was not set.
[[nodiscard]] std::filesystem::path include_root();

/// The kernels, and the models, precisions and films that they can be compiled for, as the settings
/// name them.
[[nodiscard]] std::vector<std::string> kernel_names();
[[nodiscard]] std::vector<std::string> kernel_models();
[[nodiscard]] std::vector<std::string> kernel_precisions();
[[nodiscard]] std::vector<std::string> kernel_films();

/// The translation unit: one include and one kernel that calls its template.
/// Throws std::invalid_argument naming what is unknown or out of range.
[[nodiscard]] std::string kernel_source(const KernelSpecification& specification);

/// The same with all that the compiler needs; `architecture` is 10 * major + minor.
/// Throws std::invalid_argument.
[[nodiscard]] Translation kernel_translation(const KernelSpecification& specification,
                                             int architecture);

/// The same of a replay kernel.
[[nodiscard]] std::string kernel_source(const ReplaySpecification& specification);
[[nodiscard]] Translation kernel_translation(const ReplaySpecification& specification,
                                             int architecture);

}  // namespace haste::cuda
