#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "cuda/check.h"
#include "cuda/stream.h"
#include "host/large_array.h"

namespace haste::cuda {

/// An array in device memory. May be empty; then no memory is held and `data()` is null.
template <class T>
class DeviceBuffer {
    static_assert(std::is_trivially_copyable_v<T>, "device memory is copied byte by byte");

public:
    DeviceBuffer() = default;

    /// Room for `size` elements, contents undefined. Throws CudaError if there is none; the context
    /// stays usable.
    explicit DeviceBuffer(std::size_t size) : size_(size) {
        if (size > 0) {
            HASTE_CUDA_CHECK(driver().mem_alloc(&address_, bytes()),
                             std::to_string(bytes()) + " bytes");
        }
    }

    /// A copy of the host's array.
    explicit DeviceBuffer(std::span<const T> host) : DeviceBuffer(host.size()) { upload(host); }

    ~DeviceBuffer() {
        if (address_ != 0) {
            report(driver().mem_free(address_), "cuMemFree");
        }
    }
    DeviceBuffer(DeviceBuffer&& other) noexcept
        : address_(std::exchange(other.address_, 0)), size_(std::exchange(other.size_, 0)) {}
    DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
        std::swap(address_, other.address_);
        std::swap(size_, other.size_);
        return *this;
    }

    /// Copies the host's array to the front of the buffer and waits until it is there, also for
    /// streams that do not wait for the default stream. Throws std::length_error if it is longer.
    void upload(std::span<const T> host) {
        require_room(host.size());
        if (!host.empty()) {
            HASTE_CUDA_CHECK(
                driver().memcpy_host_to_device(address_, host.data(), host.size_bytes()));
            HASTE_CUDA_CHECK(driver().stream_synchronize(nullptr));
        }
    }

    /// The same, behind the work in `stream`. `host` must stay until that is done.
    void upload(std::span<const T> host, const Stream& stream) {
        require_room(host.size());
        if (!host.empty()) {
            HASTE_CUDA_CHECK(driver().memcpy_host_to_device_async(
                address_, host.data(), host.size_bytes(), stream.handle()));
        }
    }

    /// Copies the front of the buffer to the host's array. Throws std::length_error if that is
    /// longer. Waits for the default stream only: synchronise other streams first.
    void download(std::span<T> host) const {
        require_room(host.size());
        if (!host.empty()) {
            HASTE_CUDA_CHECK(
                driver().memcpy_device_to_host(host.data(), address_, host.size_bytes()));
        }
    }

    /// The same from element `first` on, behind the work in `stream`. `host` must stay until that
    /// is done.
    void download(std::span<T> host, const Stream& stream, std::size_t first = 0) const {
        require_room(first + host.size());
        if (!host.empty()) {
            HASTE_CUDA_CHECK(driver().memcpy_device_to_host_async(
                host.data(), address_ + first * sizeof(T), host.size_bytes(), stream.handle()));
        }
    }

    /// The whole buffer. See `download`.
    [[nodiscard]] std::vector<T> download() const {
        std::vector<T> host(size_);
        download(std::span<T>(host));
        return host;
    }

    /// Copies another buffer of the same size on the device, behind the work in `stream`.
    void copy_from(const DeviceBuffer& other, const Stream& stream) {
        require_room(other.size_);
        if (other.size_ > 0) {
            HASTE_CUDA_CHECK(driver().memcpy_device_to_device_async(
                address_, other.address_, other.bytes(), stream.handle()));
        }
    }

    /// Sets every byte to zero, behind the work in `stream`.
    void clear(const Stream& stream) {
        if (size_ > 0) {
            HASTE_CUDA_CHECK(driver().memset_d8_async(address_, 0, bytes(), stream.handle()));
        }
    }

    /// The device's pointer, for a kernel's parameters. The host cannot read through it.
    [[nodiscard]] T* data() const { return reinterpret_cast<T*>(address_); }
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] std::size_t bytes() const { return size_ * sizeof(T); }

private:
    void require_room(std::size_t count) const {
        if (count > size_) {
            throw std::length_error("a copy of " + std::to_string(count) +
                                    " elements does not fit a device buffer of " +
                                    std::to_string(size_));
        }
    }

    CUdeviceptr address_ = 0;
    std::size_t size_ = 0;
};

/// An array in page-locked host memory: copies from and to it run beside the host's work and other
/// streams'.
template <class T>
class PinnedBuffer {
    static_assert(std::is_trivially_copyable_v<T>, "it is copied byte by byte");

public:
    PinnedBuffer() = default;

    /// Room for `size` elements, contents undefined. Throws CudaError, and std::bad_alloc.
    explicit PinnedBuffer(std::size_t size) : size_(size) {
        const std::size_t bytes = size * sizeof(T);
        if (bytes >= LargeArray<T>::large_bytes) {
            LargeArray<T> memory(size);
            HASTE_CUDA_CHECK(driver().mem_host_register(memory.data(), bytes, 0),
                             std::to_string(bytes) + " bytes of the host");
            large_ = std::move(memory);
        } else if (size > 0) {
            HASTE_CUDA_CHECK(driver().mem_host_alloc(&small_, bytes, 0),
                             std::to_string(bytes) + " bytes of the host");
        }
    }

    ~PinnedBuffer() {
        if (large_.data() != nullptr) {
            report(driver().mem_host_unregister(large_.data()), "cuMemHostUnregister");
        }
        if (small_ != nullptr) report(driver().mem_free_host(small_), "cuMemFreeHost");
    }
    PinnedBuffer(PinnedBuffer&& other) noexcept
        : large_(std::move(other.large_)),
          small_(std::exchange(other.small_, nullptr)),
          size_(std::exchange(other.size_, 0)) {}
    PinnedBuffer& operator=(PinnedBuffer&& other) noexcept {
        std::swap(large_, other.large_);
        std::swap(small_, other.small_);
        std::swap(size_, other.size_);
        return *this;
    }

    [[nodiscard]] T* data() const {
        return large_.data() != nullptr ? large_.data() : static_cast<T*>(small_);
    }
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] std::span<T> front(std::size_t count) const { return {data(), count}; }

private:
    /// Page-locked in large pages, which takes a fraction of the time; whole pages of its own.
    LargeArray<T> large_;
    void* small_ = nullptr;  ///< from the driver, whose pages small arrays share
    std::size_t size_ = 0;
};

}  // namespace haste::cuda
