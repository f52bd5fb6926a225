#pragma once

#include <cstddef>
#include <string>

#include "cuda/driver_api.h"

namespace haste::cuda {

/// What a report says about a GPU, and what the compiler needs to know of it.
struct DeviceInfo {
    std::string name;
    std::string uuid;  ///< "GPU-xxxxxxxx-xxxx-...", as nvidia-smi prints it
    int compute_capability_major = 0;
    int compute_capability_minor = 0;
    int multiprocessors = 0;
    std::size_t memory_bytes = 0;
    std::size_t l2_cache_bytes = 0;
    int clock_khz = 0;         ///< highest SM clock
    int memory_clock_khz = 0;  ///< highest memory clock
    int max_threads_per_block = 0;
    int max_threads_per_multiprocessor = 0;
    int max_shared_memory_per_block = 0;  ///< with opt-in
    int driver_version = 0;               ///< 1000 * major + 10 * minor
};

/// One GPU with its primary context, which lives as long as the object does. Buffers, streams,
/// events and kernels belong to the context: they must be destroyed first.
class Device {
public:
    /// Retains the primary context and makes it current. Throws CudaError without a GPU, or if
    /// there is no device `ordinal`.
    explicit Device(int ordinal = 0);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    /// Makes the context current to the calling thread. Every thread that calls CUDA needs this.
    void make_current() const;

    [[nodiscard]] const DeviceInfo& info() const { return info_; }

private:
    CUdevice device_ = 0;
    CUcontext context_ = nullptr;
    DeviceInfo info_;
};

/// What the driver says about device `ordinal`, without a context. Throws CudaError.
[[nodiscard]] DeviceInfo query_device(int ordinal);

}  // namespace haste::cuda
