#include "cuda/device.h"

#include <array>
#include <string_view>

#include "cuda/check.h"

namespace haste::cuda {

namespace {

std::string uuid_text(const CUuuid& uuid) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text = "GPU";
    for (int i = 0; i < 16; ++i) {
        if (i == 0 || i == 4 || i == 6 || i == 8 || i == 10) {
            text += '-';
        }
        text += digits[uuid.bytes[i] >> 4];
        text += digits[uuid.bytes[i] & 15];
    }
    return text;
}

CUdevice device_handle(int ordinal) {
    CUdevice device = 0;
    HASTE_CUDA_CHECK(driver().device_get(&device, ordinal), "device " + std::to_string(ordinal));
    return device;
}

}  // namespace

DeviceInfo query_device(int ordinal) {
    const DriverApi& api = driver();
    const CUdevice device = device_handle(ordinal);
    const auto attribute = [&](DeviceAttribute which) {
        int value = 0;
        HASTE_CUDA_CHECK(api.device_get_attribute(&value, which, device),
                         "attribute " + std::to_string(static_cast<int>(which)));
        return value;
    };
    DeviceInfo info;
    std::array<char, 256> name{};
    HASTE_CUDA_CHECK(api.device_get_name(name.data(), static_cast<int>(name.size()), device));
    info.name = name.data();
    CUuuid uuid{};
    HASTE_CUDA_CHECK(api.device_get_uuid(&uuid, device));
    info.uuid = uuid_text(uuid);
    HASTE_CUDA_CHECK(api.device_total_mem(&info.memory_bytes, device));
    info.compute_capability_major = attribute(DeviceAttribute::compute_capability_major);
    info.compute_capability_minor = attribute(DeviceAttribute::compute_capability_minor);
    info.multiprocessors = attribute(DeviceAttribute::multiprocessor_count);
    info.l2_cache_bytes = static_cast<std::size_t>(attribute(DeviceAttribute::l2_cache_bytes));
    info.clock_khz = attribute(DeviceAttribute::clock_rate_khz);
    info.memory_clock_khz = attribute(DeviceAttribute::memory_clock_rate_khz);
    info.max_threads_per_block = attribute(DeviceAttribute::max_threads_per_block);
    info.max_threads_per_multiprocessor =
        attribute(DeviceAttribute::max_threads_per_multiprocessor);
    info.max_shared_memory_per_block =
        attribute(DeviceAttribute::max_shared_memory_per_block_opt_in);
    info.driver_version = driver_version().value_or(0);
    return info;
}

Device::Device(int ordinal) : device_(device_handle(ordinal)), info_(query_device(ordinal)) {
    HASTE_CUDA_CHECK(driver().primary_context_retain(&context_, device_), info_.name);
    make_current();
}

Device::~Device() {
    report(driver().primary_context_release(device_), "cuDevicePrimaryCtxRelease");
}

void Device::make_current() const { HASTE_CUDA_CHECK(driver().context_set_current(context_)); }

}  // namespace haste::cuda
