// A driver of a GPU that is the processor: memory of the device is ordinary memory between guards,
// every call is done when it returns, and a kernel's threads run one after another. It can be told
// to err, by EMULATION_FAULT: `lost block` and `lost memory`.
#include <dlfcn.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>

namespace {

using Launch = void (*)(const void*, unsigned, unsigned);

constexpr std::size_t guard = 256;
constexpr unsigned char guard_byte = 0xa5;

struct Live {
    std::map<char*, std::size_t> device;
    std::map<void*, std::size_t> registered;
    std::map<void*, std::size_t> pinned;
    long others = 0;  // streams, events and modules
};

Live& live() {
    static Live shared;
    return shared;
}

[[noreturn]] void die(const char* what) {
    std::fprintf(stderr, "emulated driver: %s\n", what);
    std::abort();
}

/// Copies and fills stay within one array of the device.
void check_range(unsigned long long address, std::size_t bytes) {
    auto* const begin = reinterpret_cast<char*>(address);
    auto found = live().device.upper_bound(begin);
    if (found == live().device.begin()) die("no such device memory");
    --found;
    if (begin + bytes > found->first + found->second) die("a copy leaves its array");
}

struct Event {
    std::chrono::steady_clock::time_point when;
};

int opaque;  // what handles point to

bool errs(const char* fault) {
    const char* const told = std::getenv("EMULATION_FAULT");
    return told != nullptr && std::strcmp(told, fault) == 0;
}

}  // namespace

extern "C" {

int cuInit(unsigned) { return 0; }
int cuDriverGetVersion(int* version) { return *version = 13000, 0; }
int cuGetErrorName(int, const char** text) { return *text = "CUDA_ERROR_EMULATED", 0; }
int cuGetErrorString(int, const char** text) { return *text = "the emulation refuses", 0; }
int cuDeviceGetCount(int* count) { return *count = 1, 0; }
int cuDeviceGet(int* device, int) { return *device = 0, 0; }
int cuDeviceGetName(char* name, int, int) { return std::strcpy(name, "emulated"), 0; }
int cuDeviceGetUuid_v2(void* uuid, int) { return std::memset(uuid, 0, 16), 0; }
int cuDeviceTotalMem_v2(std::size_t* bytes, int) { return *bytes = 1ull << 33, 0; }

int cuDeviceGetAttribute(int* value, int which, int) {
    switch (which) {
        case 1:  // threads a block
            *value = 1024;
            break;
        case 16:  // multiprocessors
            *value = 2;
            break;
        case 39:  // threads a multiprocessor
            *value = 256;
            break;
        case 75:  // compute capability
            *value = 9;
            break;
        case 76:
            *value = 0;
            break;
        default:
            *value = 1 << 16;
    }
    return 0;
}

int cuDevicePrimaryCtxRetain(void** context, int) { return *context = &opaque, 0; }
int cuDevicePrimaryCtxRelease_v2(int) { return 0; }
int cuCtxSetCurrent(void*) { return 0; }

int cuModuleLoadData(void** module, const void* image) {
    *module = dlopen(static_cast<const char*>(image), RTLD_NOW | RTLD_LOCAL);
    if (*module == nullptr) die(dlerror());
    ++live().others;
    return 0;
}
int cuModuleUnload(void*) { return --live().others, 0; }
int cuModuleGetFunction(void** function, void* module, const char*) {
    *function = dlsym(module, "emulated_launch");
    return *function == nullptr ? 500 : 0;
}
int cuFuncGetAttribute(int* value, int which, void*) { return *value = which == 0 ? 1024 : 0, 0; }
int cuFuncGetParamInfo(void*, std::size_t, std::size_t* offset, std::size_t* size) {
    return *offset = *size = 0, 0;
}
int cuOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, void*, int, std::size_t) {
    return *blocks = 2, 0;
}
int cuLaunchKernel(void* function, unsigned blocks, unsigned, unsigned, unsigned threads, unsigned,
                   unsigned, unsigned, void*, void** parameters, void**) {
    if (blocks > 1 && errs("lost block")) --blocks;
    reinterpret_cast<Launch>(function)(parameters[0], blocks, threads);
    return 0;
}

int cuMemAlloc_v2(unsigned long long* address, std::size_t bytes) {
    const std::size_t size = (guard + bytes + guard + 255) / 256 * 256;
    auto* const whole = static_cast<char*>(std::aligned_alloc(256, size));
    if (whole == nullptr) return 2;
    std::memset(whole, guard_byte, size);
    // What nobody has written is no number, and no small count.
    std::memset(whole + guard, 0xff, bytes);
    live().device[whole + guard] = bytes;
    *address = reinterpret_cast<unsigned long long>(whole + guard);
    return 0;
}
int cuMemFree_v2(unsigned long long address) {
    if (errs("lost memory")) return 0;
    auto* const begin = reinterpret_cast<char*>(address);
    const auto found = live().device.find(begin);
    if (found == live().device.end()) die("device memory is freed that is none");
    for (std::size_t i = 0; i < guard; ++i) {
        const bool whole = static_cast<unsigned char>(begin[-1 - long(i)]) == guard_byte &&
                           static_cast<unsigned char>(begin[found->second + i]) == guard_byte;
        if (!whole) die("an array was written beyond its ends");
    }
    live().device.erase(found);
    std::free(begin - guard);
    return 0;
}

int cuMemHostAlloc(void** address, std::size_t bytes, unsigned) {
    *address = std::malloc(bytes);
    live().pinned[*address] = bytes;
    return 0;
}
int cuMemFreeHost(void* address) {
    if (live().pinned.erase(address) != 1) die("page-locked memory is freed that is none");
    std::free(address);
    return 0;
}
int cuMemHostRegister_v2(void* address, std::size_t bytes, unsigned) {
    constexpr std::size_t page = 4096;
    if (reinterpret_cast<std::size_t>(address) % page != 0) die("part of a page is page-locked");
    live().registered[address] = bytes;
    return 0;
}
int cuMemHostUnregister(void* address) {
    if (live().registered.erase(address) != 1) die("memory is unlocked that was not locked");
    return 0;
}

int cuMemcpyHtoD_v2(unsigned long long to, const void* from, std::size_t bytes) {
    check_range(to, bytes);
    return std::memcpy(reinterpret_cast<void*>(to), from, bytes), 0;
}
int cuMemcpyDtoH_v2(void* to, unsigned long long from, std::size_t bytes) {
    check_range(from, bytes);
    return std::memcpy(to, reinterpret_cast<void*>(from), bytes), 0;
}
int cuMemcpyHtoDAsync_v2(unsigned long long to, const void* from, std::size_t bytes, void*) {
    return cuMemcpyHtoD_v2(to, from, bytes);
}
int cuMemcpyDtoHAsync_v2(void* to, unsigned long long from, std::size_t bytes, void*) {
    return cuMemcpyDtoH_v2(to, from, bytes);
}
int cuMemcpyDtoDAsync_v2(unsigned long long to, unsigned long long from, std::size_t bytes, void*) {
    check_range(to, bytes);
    check_range(from, bytes);
    return std::memmove(reinterpret_cast<void*>(to), reinterpret_cast<void*>(from), bytes), 0;
}
int cuMemsetD8Async(unsigned long long to, unsigned char value, std::size_t bytes, void*) {
    check_range(to, bytes);
    return std::memset(reinterpret_cast<void*>(to), value, bytes), 0;
}

int cuStreamCreate(void** stream, unsigned) { return ++live().others, *stream = &opaque, 0; }
int cuStreamDestroy_v2(void*) { return --live().others, 0; }
int cuStreamSynchronize(void*) { return 0; }
int cuStreamQuery(void*) { return 0; }

int cuEventCreate(void** event, unsigned) { return ++live().others, *event = new Event, 0; }
int cuEventDestroy_v2(void* event) {
    delete static_cast<Event*>(event);
    return --live().others, 0;
}
int cuEventRecord(void* event, void*) {
    static_cast<Event*>(event)->when = std::chrono::steady_clock::now();
    return 0;
}
int cuEventSynchronize(void*) { return 0; }
int cuEventElapsedTime(float* milliseconds, void* start, void* end) {
    const auto passed = static_cast<Event*>(end)->when - static_cast<Event*>(start)->when;
    *milliseconds = std::chrono::duration<float, std::milli>(passed).count();
    return 0;
}

/// Arrays, streams, events and modules that were made and not given back.
long emulated_live() {
    const Live& now = live();
    return long(now.device.size() + now.registered.size() + now.pinned.size()) + now.others;
}

}  // extern "C"
