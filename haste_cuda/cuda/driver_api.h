#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace haste::cuda {

// The driver's types under the driver's names, declared here so that building needs no CUDA
// headers. Layouts and values are part of the driver's binary interface and do not change.
using CUresult = int;
using CUdevice = int;
using CUdeviceptr = unsigned long long;
using CUcontext = struct CUctx_st*;
using CUmodule = struct CUmod_st*;
using CUfunction = struct CUfunc_st*;
using CUstream = struct CUstream_st*;
using CUevent = struct CUevent_st*;
struct CUuuid {
    unsigned char bytes[16];
};

/// The few results that the code tells apart.
inline constexpr CUresult cuda_success = 0;
inline constexpr CUresult cuda_error_deinitialized = 4;
inline constexpr CUresult cuda_error_not_ready = 600;

/// CUdevice_attribute.
enum class DeviceAttribute : int {
    max_threads_per_block = 1,
    clock_rate_khz = 13,
    multiprocessor_count = 16,
    memory_clock_rate_khz = 36,
    l2_cache_bytes = 38,
    max_threads_per_multiprocessor = 39,
    compute_capability_major = 75,
    compute_capability_minor = 76,
    max_shared_memory_per_block_opt_in = 97,
};

/// CUfunction_attribute.
enum class FunctionAttribute : int {
    max_threads_per_block = 0,
    local_bytes = 3,
    registers = 4,
};

/// CUstream_flags and CUevent_flags.
inline constexpr unsigned stream_non_blocking = 1;
inline constexpr unsigned event_default = 0;

/// The driver's entry points, found in libcuda.so.1 at run time. `_v2` and later symbols are used
/// where the driver has them: those without a suffix are the 32-bit interface of CUDA 3.
struct DriverApi {
    CUresult (*get_error_name)(CUresult, const char**);
    CUresult (*get_error_string)(CUresult, const char**);
    CUresult (*init)(unsigned flags);
    CUresult (*driver_get_version)(int* version);

    CUresult (*device_get_count)(int* count);
    CUresult (*device_get)(CUdevice*, int ordinal);
    CUresult (*device_get_name)(char* name, int size, CUdevice);
    CUresult (*device_get_uuid)(CUuuid*, CUdevice);
    CUresult (*device_total_mem)(std::size_t* bytes, CUdevice);
    CUresult (*device_get_attribute)(int* value, DeviceAttribute, CUdevice);

    CUresult (*primary_context_retain)(CUcontext*, CUdevice);
    CUresult (*primary_context_release)(CUdevice);
    CUresult (*context_set_current)(CUcontext);

    CUresult (*module_load_data)(CUmodule*, const void* image);
    CUresult (*module_unload)(CUmodule);
    CUresult (*module_get_function)(CUfunction*, CUmodule, const char* name);
    CUresult (*function_get_attribute)(int* value, FunctionAttribute, CUfunction);
    CUresult (*occupancy_max_active_blocks)(int* blocks, CUfunction, int block_size,
                                            std::size_t dynamic_shared_bytes);
    CUresult (*launch_kernel)(CUfunction, unsigned grid_x, unsigned grid_y, unsigned grid_z,
                              unsigned block_x, unsigned block_y, unsigned block_z,
                              unsigned dynamic_shared_bytes, CUstream, void** parameters,
                              void** extra);

    CUresult (*mem_alloc)(CUdeviceptr*, std::size_t bytes);
    CUresult (*mem_free)(CUdeviceptr);
    CUresult (*mem_host_alloc)(void**, std::size_t bytes, unsigned flags);
    CUresult (*mem_free_host)(void*);
    CUresult (*mem_host_register)(void*, std::size_t bytes, unsigned flags);
    CUresult (*mem_host_unregister)(void*);
    CUresult (*memcpy_host_to_device)(CUdeviceptr, const void*, std::size_t bytes);
    CUresult (*memcpy_device_to_host)(void*, CUdeviceptr, std::size_t bytes);
    CUresult (*memcpy_host_to_device_async)(CUdeviceptr, const void*, std::size_t bytes, CUstream);
    CUresult (*memcpy_device_to_host_async)(void*, CUdeviceptr, std::size_t bytes, CUstream);
    CUresult (*memcpy_device_to_device_async)(CUdeviceptr, CUdeviceptr, std::size_t bytes,
                                              CUstream);
    CUresult (*memset_d8_async)(CUdeviceptr, unsigned char value, std::size_t bytes, CUstream);

    CUresult (*stream_create)(CUstream*, unsigned flags);
    CUresult (*stream_destroy)(CUstream);
    CUresult (*stream_synchronize)(CUstream);
    CUresult (*stream_query)(CUstream);

    CUresult (*event_create)(CUevent*, unsigned flags);
    CUresult (*event_destroy)(CUevent);
    CUresult (*event_record)(CUevent, CUstream);
    CUresult (*event_synchronize)(CUevent);
    CUresult (*event_elapsed_time)(float* milliseconds, CUevent start, CUevent end);

    /// Optional (drivers from CUDA 12.4 on; null before): offset and size of a kernel's parameter.
    CUresult (*function_get_parameter)(CUfunction, std::size_t index, std::size_t* offset,
                                       std::size_t* size);
};

/// Why CUDA cannot be used here (no driver library, no device, a driver older than CUDA 12.0), or
/// nothing. Finds out once a process and creates no context.
[[nodiscard]] std::optional<std::string> driver_unavailable();

/// The initialised driver. Throws CudaError with the reason of `driver_unavailable()`.
[[nodiscard]] const DriverApi& driver();

/// The newest CUDA version that the driver supports, 1000 * major + 10 * minor (13000 for 13.0);
/// empty where `driver_unavailable()` has a reason.
[[nodiscard]] std::optional<int> driver_version();

/// "13.0" for 13000.
[[nodiscard]] std::string version_text(int version);

}  // namespace haste::cuda
