#include "cuda/kernel_source.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <mutex>
#include <span>
#include <stdexcept>

#include "core/accel/traversal.h"
#include "core/base/features.h"
#include "cuda/kernels/resident_params.h"

namespace haste::cuda {

namespace {

/// A name in the settings and the core's type of that name.
struct ModelEntry {
    std::string_view name;
    std::string_view type;
};

constexpr std::array models{
    ModelEntry{"haste", "haste::HasteModel"},
    ModelEntry{"whitted", "haste::WhittedModel"},
    ModelEntry{"path", "haste::PathModel"},
};

/// A precision is a type of the core and a set of compiler options.
struct PrecisionEntry {
    std::string_view name;
    std::string_view type;
    std::string_view options;  ///< separated by spaces
};

constexpr std::array precisions{
    PrecisionEntry{"watertight", "haste::Watertight", "--fmad=false"},
    PrecisionEntry{"fast", "haste::Fast", "--use_fast_math"},
};

/// A film is the type that a thread adds up what it contributes.
struct FilmEntry {
    std::string_view name;
    std::string_view type;
};

constexpr std::array films{
    FilmEntry{"int64", "haste::FilmSum"},
    FilmEntry{"float_atomic", "haste::FloatSum"},
};

/// A kernel is a header, a function template in it and the structure that the function is given.
struct KernelEntry {
    std::string_view name;
    std::string_view header;
    std::string_view parameters;
    bool only_traces = false;  ///< by resident warps, where the traversal has such
};

constexpr std::array kernels{
    KernelEntry{"depth_first", "depth_first.cuh", "haste::RenderParams"},
    KernelEntry{"packet", "packet.cuh", "haste::PacketParams"},
    KernelEntry{"wavefront_plan", "wavefront.cuh", "haste::WavefrontParams"},
    KernelEntry{"wavefront_generate", "wavefront.cuh", "haste::WavefrontParams"},
    KernelEntry{"wavefront_closest_hit", "wavefront.cuh", "haste::WavefrontParams", true},
    KernelEntry{"wavefront_shade", "wavefront.cuh", "haste::WavefrontParams"},
    KernelEntry{"wavefront_any_hit", "wavefront.cuh", "haste::WavefrontParams", true},
    KernelEntry{"persistent", "persistent.cuh", "haste::PersistentParams"},
};

template <class Entry>
std::vector<std::string> names_of(std::span<const Entry> entries) {
    std::vector<std::string> names;
    for (const Entry& entry : entries) {
        names.emplace_back(entry.name);
    }
    return names;
}

template <class Entry>
const Entry& find(std::span<const Entry> entries, std::string_view name, std::string_view kind) {
    std::string known;
    for (const Entry& entry : entries) {
        if (entry.name == name) {
            return entry;
        }
        known += (known.empty() ? "" : ", ") + std::string(entry.name);
    }
    throw std::invalid_argument("haste-cuda has no " + std::string(kind) + " '" +
                                std::string(name) + "'; it has " + known);
}

struct IncludeRoot {
    std::mutex mutex;
    std::filesystem::path path;
};

IncludeRoot& shared_include_root() {
    static IncludeRoot shared;
    return shared;
}

std::string hexadecimal(std::uint32_t bits) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "0x%x", bits);
    return text.data();
}

/// Which kinds of primitive a scene has: all that a replay kernel is compiled for.
std::uint32_t primitive_features(std::uint32_t features) {
    return features & (feature_triangles | feature_spheres);
}

/// The headers of features, before those of a kernel, which calls what they define.
std::string feature_headers(std::uint32_t features) {
    std::string lines;
    for (std::uint32_t i = 0; i < feature_count; ++i) {
        if (!(features >> i & 1)) continue;
        lines += "#include \"core/features/" + std::string(feature_names[i]) + ".h\"\n";
    }
    return lines;
}

/// Two such blocks a multiprocessor leave a thread 64 registers, which are enough: the compiler by
/// itself takes a few more and the multiprocessor runs fewer warps.
std::string resident_bounds() {
    return "__launch_bounds__(" + std::to_string(max_resident_block) + ", 2) ";
}

void check_traversal(const std::string& name) {
    std::string known;
    for (const char* traversal : traversal_names) {
        if (name == traversal) return;
        known += (known.empty() ? "" : ", ") + std::string(traversal);
    }
    throw std::invalid_argument("haste-cuda has no traversal '" + name + "'; it has " + known);
}

const char* query_name(bool any_hit) { return any_hit ? "any_hit" : "closest"; }

/// What the compiler needs beside the source.
Translation translation_of(std::string source, std::string name, std::string_view options,
                           int architecture) {
    Translation translation{.source = std::move(source),
                            .name = std::move(name),
                            .include_root = include_root(),
                            .architecture = architecture,
                            .options = {}};
    for (std::string_view rest = options; !rest.empty();) {
        const std::size_t end = std::min(rest.find(' '), rest.size());
        translation.options.emplace_back(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return translation;
}

}  // namespace

std::string KernelSpecification::name() const {
    return kernel + " " + model + " " + precision + " features=" + hexadecimal(features) + " " +
           traversal + " stack=" + std::to_string(stack_capacity) + " film=" + film +
           " layered=" + (layered ? "1" : "0") + " count=" + (count_rays ? "1" : "0");
}

std::string ReplaySpecification::name() const {
    return std::string("replay ") + query_name(any_hit) + " " + traversal + " " + precision +
           " features=" + hexadecimal(primitive_features(features)) +
           " count=" + (count ? "1" : "0");
}

void set_include_root(const std::filesystem::path& root) {
    IncludeRoot& shared = shared_include_root();
    const std::lock_guard lock(shared.mutex);
    shared.path = root;
}

std::filesystem::path include_root() {
    IncludeRoot& shared = shared_include_root();
    const std::lock_guard lock(shared.mutex);
    if (shared.path.empty()) {
        throw std::logic_error("the folder of the kernels' headers was not set");
    }
    return shared.path;
}

std::vector<std::string> kernel_names() { return names_of<KernelEntry>(kernels); }

std::vector<std::string> kernel_models() { return names_of<ModelEntry>(models); }

std::vector<std::string> kernel_precisions() { return names_of<PrecisionEntry>(precisions); }

std::vector<std::string> kernel_films() { return names_of<FilmEntry>(films); }

std::string kernel_source(const KernelSpecification& specification) {
    const auto& kernel = find<KernelEntry>(kernels, specification.kernel, "kernel");
    const auto& model = find<ModelEntry>(models, specification.model, "kernel for the model");
    const auto& precision =
        find<PrecisionEntry>(precisions, specification.precision, "kernel for the precision");
    const auto& film = find<FilmEntry>(films, specification.film, "kernel for the film");
    if (specification.stack_capacity < 1) {
        throw std::invalid_argument("a kernel's stack holds at least one ray, not " +
                                    std::to_string(specification.stack_capacity));
    }
    check_traversal(specification.traversal);
    const auto flag = [](bool value) { return std::string(value ? "true" : "false"); };
    std::string source = feature_headers(specification.features) + "#include \"cuda/kernels/" +
                         std::string(kernel.header) + "\"\n";
    source += "using Config = haste::KernelConfig<" + std::string(model.type) +
              ", haste::Features<" + hexadecimal(specification.features) + "u>, " +
              std::string(precision.type) + ", haste::TraversalKind::" + specification.traversal +
              ", " + std::to_string(specification.stack_capacity) + ", " + std::string(film.type) +
              ", " + flag(specification.layered) + ", " + flag(specification.count_rays) + ">;\n";
    // A grid constant stays in constant memory where its address is taken.
    const bool resident =
        kernel.only_traces && specification.traversal == name_of(TraversalKind::bvh8);
    source += "extern \"C\" __global__ void " + (resident ? resident_bounds() : "") + kernel_entry +
              "(const __grid_constant__ " + std::string(kernel.parameters) + " parameters) {\n";
    source += "    haste::" + std::string(kernel.name) + "<Config>(parameters);\n}\n";
    return source;
}

Translation kernel_translation(const KernelSpecification& specification, int architecture) {
    const auto& precision =
        find<PrecisionEntry>(precisions, specification.precision, "kernel for the precision");
    return translation_of(kernel_source(specification),
                          specification.kernel + "_" + specification.model + ".cu",
                          precision.options, architecture);
}

std::string kernel_source(const ReplaySpecification& specification) {
    const auto& precision =
        find<PrecisionEntry>(precisions, specification.precision, "kernel for the precision");
    const std::uint32_t features = primitive_features(specification.features);
    if (features == 0) {
        throw std::invalid_argument("a replay kernel needs triangles, spheres or both");
    }
    check_traversal(specification.traversal);
    const std::string query = "haste::QueryKind::" + std::string(query_name(specification.any_hit));
    const std::string types =
        "haste::Features<" + hexadecimal(features) + "u>, " + std::string(precision.type);
    const std::string signature =
        std::string(kernel_entry) + "(const __grid_constant__ haste::ReplayParams parameters) {\n";
    const std::string headers = feature_headers(features);
    if (specification.resident()) {
        return headers +
               "#include \"cuda/kernels/replay_resident.cuh\"\nextern \"C\" __global__ void " +
               signature + "    haste::replay_resident<" + query + ", " + types +
               ">(parameters);\n}\n";
    }
    return headers + "#include \"cuda/kernels/replay.cuh\"\nextern \"C\" __global__ void " +
           signature + "    haste::replay<" + query +
           ", haste::TraversalKind::" + specification.traversal + ", " + types + ", " +
           (specification.count ? "true" : "false") + ">(parameters);\n}\n";
}

Translation kernel_translation(const ReplaySpecification& specification, int architecture) {
    const auto& precision =
        find<PrecisionEntry>(precisions, specification.precision, "kernel for the precision");
    return translation_of(kernel_source(specification),
                          std::string("replay_") + query_name(specification.any_hit) + "_" +
                              specification.traversal + ".cu",
                          precision.options, architecture);
}

}  // namespace haste::cuda
