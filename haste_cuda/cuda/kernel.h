#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <type_traits>
#include <utility>

#include "cuda/cubin_cache.h"
#include "cuda/device.h"
#include "cuda/kernel_source.h"
#include "cuda/nvrtc.h"
#include "cuda/stream.h"

namespace haste::cuda {

/// The shape of a launch. Grid and block are one-dimensional, as all work here is a list.
struct Launch {
    std::size_t blocks = 0;
    int threads = 0;  ///< of a block
    std::size_t dynamic_shared_bytes = 0;

    /// Enough blocks for one thread an item.
    [[nodiscard]] static Launch for_items(std::size_t items, int threads) {
        const auto block = static_cast<std::size_t>(threads);
        return {.blocks = (items + block - 1) / block, .threads = threads};
    }
};

/// What the driver says about a loaded kernel.
struct KernelAttributes {
    int registers = 0;
    int local_bytes = 0;
    int max_threads_per_block = 0;
};

/// A kernel on the current device.
class Kernel {
public:
    /// Loads the program into the current context and looks `entry` up. `name` is what errors and
    /// profiles call it. Throws CudaError.
    Kernel(const CachedProgram& program, const char* entry, std::string name);
    ~Kernel();
    Kernel(Kernel&& other) noexcept;
    Kernel& operator=(Kernel&&) = delete;

    /// Puts a launch behind the work in `stream`; it runs later. Does nothing if `blocks` is 0.
    /// All kernels take one structure. Throws CudaError naming the kernel if the driver refuses the
    /// launch, std::logic_error if the structure is not as large as the kernel's (drivers from CUDA
    /// 12.4).
    template <class Parameters>
    void launch(const Launch& shape, Stream& stream, const Parameters& parameters) const {
        static_assert(std::is_trivially_copyable_v<Parameters>,
                      "the driver copies parameters byte by byte");
        static_assert(sizeof(Parameters) <= 4096, "the driver takes at most 4 KiB");
        launch_untyped(shape, stream, &parameters, sizeof(Parameters));
    }

    /// Blocks of this size that one multiprocessor can run at a time.
    [[nodiscard]] int resident_blocks(int threads, std::size_t dynamic_shared_bytes = 0) const;

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] const KernelAttributes& attributes() const { return attributes_; }

    /// Seconds to compile it or to take it from the cache, to load it into the context included.
    [[nodiscard]] double build_seconds() const { return build_seconds_; }
    [[nodiscard]] bool cached() const { return cached_; }

private:
    void launch_untyped(const Launch& shape, Stream& stream, const void* parameters,
                        std::size_t size) const;

    std::string name_;
    CUmodule module_ = nullptr;
    CUfunction function_ = nullptr;
    KernelAttributes attributes_;
    std::size_t parameters_size_ = 0;  ///< 0: the driver does not tell
    double build_seconds_ = 0;
    bool cached_ = false;
};

/// The kernels of one device, each built when it is first asked for.
class KernelSet {
public:
    /// The device must outlive the set.
    explicit KernelSet(const Device& device);

    /// The kernel, from memory, the cubin cache or the compiler. The device must be current.
    /// Throws CompileError, CudaError or std::invalid_argument.
    [[nodiscard]] const Kernel& get(const KernelSpecification& specification);
    [[nodiscard]] const Kernel& get(const ReplaySpecification& specification);

    /// Seconds that building all kernels took so far.
    [[nodiscard]] double build_seconds() const { return build_seconds_; }

private:
    template <class Specification>
    const Kernel& get_or_build(const Specification& specification);

    int architecture_;
    CubinCache cache_;
    std::map<std::string, Kernel> kernels_;
    double build_seconds_ = 0;
};

}  // namespace haste::cuda
