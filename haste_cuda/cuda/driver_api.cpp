#include "cuda/driver_api.h"

#include "cuda/check.h"
#include "cuda/shared_library.h"

namespace haste::cuda {

namespace {

constexpr int oldest_version = 12000;

/// What was found out about the driver, once a process.
struct LoadedDriver {
    DriverApi api{};
    int version = 0;
    std::optional<std::string> unavailable;
};

/// Fills the table; the name of the first missing entry point, or nothing.
std::optional<std::string> find_entry_points(const SharedLibrary& library, DriverApi& api) {
    std::optional<std::string> missing;
    const auto find = [&](const char* name, auto& function) {
        if (!library.find(name, function) && !missing) {
            missing = name;
        }
    };
    find("cuGetErrorName", api.get_error_name);
    find("cuGetErrorString", api.get_error_string);
    find("cuInit", api.init);
    find("cuDriverGetVersion", api.driver_get_version);
    find("cuDeviceGetCount", api.device_get_count);
    find("cuDeviceGet", api.device_get);
    find("cuDeviceGetName", api.device_get_name);
    find("cuDeviceGetUuid_v2", api.device_get_uuid);
    find("cuDeviceTotalMem_v2", api.device_total_mem);
    find("cuDeviceGetAttribute", api.device_get_attribute);
    find("cuDevicePrimaryCtxRetain", api.primary_context_retain);
    find("cuDevicePrimaryCtxRelease_v2", api.primary_context_release);
    find("cuCtxSetCurrent", api.context_set_current);
    find("cuModuleLoadData", api.module_load_data);
    find("cuModuleUnload", api.module_unload);
    find("cuModuleGetFunction", api.module_get_function);
    find("cuFuncGetAttribute", api.function_get_attribute);
    find("cuOccupancyMaxActiveBlocksPerMultiprocessor", api.occupancy_max_active_blocks);
    find("cuLaunchKernel", api.launch_kernel);
    find("cuMemAlloc_v2", api.mem_alloc);
    find("cuMemFree_v2", api.mem_free);
    find("cuMemHostAlloc", api.mem_host_alloc);
    find("cuMemFreeHost", api.mem_free_host);
    find("cuMemHostRegister_v2", api.mem_host_register);
    find("cuMemHostUnregister", api.mem_host_unregister);
    find("cuMemcpyHtoD_v2", api.memcpy_host_to_device);
    find("cuMemcpyDtoH_v2", api.memcpy_device_to_host);
    find("cuMemcpyHtoDAsync_v2", api.memcpy_host_to_device_async);
    find("cuMemcpyDtoHAsync_v2", api.memcpy_device_to_host_async);
    find("cuMemcpyDtoDAsync_v2", api.memcpy_device_to_device_async);
    find("cuMemsetD8Async", api.memset_d8_async);
    find("cuStreamCreate", api.stream_create);
    find("cuStreamDestroy_v2", api.stream_destroy);
    find("cuStreamSynchronize", api.stream_synchronize);
    find("cuStreamQuery", api.stream_query);
    find("cuEventCreate", api.event_create);
    find("cuEventDestroy_v2", api.event_destroy);
    find("cuEventRecord", api.event_record);
    find("cuEventSynchronize", api.event_synchronize);
    find("cuEventElapsedTime", api.event_elapsed_time);
    if (!library.find("cuFuncGetParamInfo", api.function_get_parameter)) {
        api.function_get_parameter = nullptr;
    }
    return missing;
}

std::string describe(const DriverApi& api, CUresult result) {
    const char* name = nullptr;
    const char* meaning = nullptr;
    api.get_error_name(result, &name);
    api.get_error_string(result, &meaning);
    return std::string(name ? name : "unknown error") + ", " + (meaning ? meaning : "no text");
}

LoadedDriver load_driver() {
    LoadedDriver loaded;
    std::string reason;
    const std::optional<SharedLibrary> library = SharedLibrary::load("libcuda.so.1", reason);
    if (!library) {
        loaded.unavailable = "no NVIDIA driver: " + reason;
        return loaded;
    }
    if (const auto missing = find_entry_points(*library, loaded.api)) {
        loaded.unavailable = "the NVIDIA driver is too old: it has no " + *missing + "; CUDA " +
                             version_text(oldest_version) + " or newer is needed";
        return loaded;
    }
    if (const CUresult result = loaded.api.init(0); result != cuda_success) {
        loaded.unavailable = "the NVIDIA driver does not start: " + describe(loaded.api, result);
        return loaded;
    }
    if (const CUresult result = loaded.api.driver_get_version(&loaded.version);
        result != cuda_success) {
        loaded.unavailable = "the NVIDIA driver has no version: " + describe(loaded.api, result);
        return loaded;
    }
    if (loaded.version < oldest_version) {
        loaded.unavailable = "the NVIDIA driver supports CUDA " + version_text(loaded.version) +
                             "; " + version_text(oldest_version) + " or newer is needed";
        return loaded;
    }
    int count = 0;
    if (const CUresult result = loaded.api.device_get_count(&count); result != cuda_success) {
        loaded.unavailable = "the devices cannot be counted: " + describe(loaded.api, result);
    } else if (count == 0) {
        loaded.unavailable = "the NVIDIA driver sees no device";
    }
    return loaded;
}

const LoadedDriver& loaded_driver() {
    static const LoadedDriver loaded = load_driver();
    return loaded;
}

}  // namespace

std::optional<std::string> driver_unavailable() { return loaded_driver().unavailable; }

const DriverApi& driver() {
    const LoadedDriver& loaded = loaded_driver();
    if (loaded.unavailable) {
        throw CudaError("CUDA is unavailable: " + *loaded.unavailable);
    }
    return loaded.api;
}

std::optional<int> driver_version() {
    const LoadedDriver& loaded = loaded_driver();
    return loaded.unavailable ? std::nullopt : std::optional<int>(loaded.version);
}

std::string version_text(int version) {
    return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

}  // namespace haste::cuda
