#pragma once

#include <string>
#include <utility>

#include "cuda/check.h"

namespace haste::cuda {

/// A queue of work on the current device. Remembers the name of the last launch, so that a fault,
/// which surfaces only at a later call, names the kernel that is suspected.
class Stream {
public:
    /// A stream that does not wait for the default stream.
    Stream() { HASTE_CUDA_CHECK(driver().stream_create(&stream_, stream_non_blocking)); }
    ~Stream() {
        if (stream_ != nullptr) {
            report(driver().stream_destroy(stream_), "cuStreamDestroy");
        }
    }
    Stream(Stream&& other) noexcept
        : stream_(std::exchange(other.stream_, nullptr)),
          last_launch_(std::move(other.last_launch_)) {}
    Stream& operator=(Stream&& other) noexcept {
        std::swap(stream_, other.stream_);
        std::swap(last_launch_, other.last_launch_);
        return *this;
    }

    /// Waits until the work given so far is done. Throws CudaError if any of it failed.
    void synchronize() const { HASTE_CUDA_CHECK(driver().stream_synchronize(stream_), subject()); }

    /// Whether the work given so far is done. Throws CudaError if any of it failed.
    [[nodiscard]] bool finished() const {
        const CUresult result = driver().stream_query(stream_);
        if (result == cuda_error_not_ready) {
            return false;
        }
        HASTE_CUDA_CHECK(result, subject());
        return true;
    }

    [[nodiscard]] CUstream handle() const { return stream_; }

    /// Called by Kernel::launch.
    void note_launch(const std::string& name) { last_launch_ = name; }

private:
    [[nodiscard]] std::string subject() const {
        return last_launch_.empty() ? std::string() : "last launch: " + last_launch_;
    }

    CUstream stream_ = nullptr;
    std::string last_launch_;
};

}  // namespace haste::cuda
