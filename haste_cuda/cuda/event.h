#pragma once

#include <utility>

#include "cuda/check.h"
#include "cuda/stream.h"

namespace haste::cuda {

/// A mark in a stream: for timing, and for waiting until the work before it is done.
class Event {
public:
    Event() { HASTE_CUDA_CHECK(driver().event_create(&event_, event_default)); }
    ~Event() {
        if (event_ != nullptr) {
            report(driver().event_destroy(event_), "cuEventDestroy");
        }
    }
    Event(Event&& other) noexcept : event_(std::exchange(other.event_, nullptr)) {}
    Event& operator=(Event&& other) noexcept {
        std::swap(event_, other.event_);
        return *this;
    }

    /// Sets the mark behind all work given to the stream so far.
    void record(const Stream& stream) {
        HASTE_CUDA_CHECK(driver().event_record(event_, stream.handle()));
    }

    /// Makes the host wait for the mark.
    void synchronize() const { HASTE_CUDA_CHECK(driver().event_synchronize(event_)); }

    [[nodiscard]] CUevent handle() const { return event_; }

private:
    CUevent event_ = nullptr;
};

/// Seconds between two recorded marks, by the device's clock (resolution about half a microsecond).
/// Waits for the second.
[[nodiscard]] inline double seconds_between(const Event& start, const Event& end) {
    end.synchronize();
    float milliseconds = 0;
    HASTE_CUDA_CHECK(driver().event_elapsed_time(&milliseconds, start.handle(), end.handle()));
    return 1e-3 * static_cast<double>(milliseconds);
}

}  // namespace haste::cuda
