#pragma once

#include <utility>
#include <vector>

#include "core/config.h"
#include "host/stopwatch.h"

namespace haste {

/// What a stretch of a pass's time goes into.
enum class WorkKind { pop, allocate, upload, trace, download, push };

/// A stretch of time, in seconds from the beginning of the pass.
struct WorkSpan {
    WorkKind kind;
    u32 lane;  ///< stream that it belongs to
    double begin, end;
    u64 rays;  ///< that were moved or traced
};

/// What an engine did beside tracing rays.
struct ScheduleWork {
    u64 launches = 0;             ///< packets, slices of layers, or samples that were launched
    u64 bytes_moved = 0;          ///< between host and device, both ways
    std::vector<WorkSpan> spans;  ///< only where they are asked for

    /// Adds a pass that began so many seconds after the first.
    void append(const ScheduleWork& pass, double start) {
        launches += pass.launches;
        bytes_moved += pass.bytes_moved;
        for (WorkSpan span : pass.spans) {
            span.begin += start;
            span.end += start;
            spans.push_back(span);
        }
    }
};

/// Notes what the host does or waits for, by the host's clock, where that is asked for.
class WorkLog {
public:
    explicit WorkLog(bool wanted) : wanted_(wanted) {}

    /// Does some work, which returns the rays that it handled; returns them, too.
    template <class Work>
    u64 time(WorkKind kind, Work&& work) {
        const double begin = watch_.seconds();
        const u64 rays = work();
        if (wanted_) spans_.push_back({kind, 0, begin, watch_.seconds(), rays});
        return rays;
    }

    [[nodiscard]] double seconds() const { return watch_.seconds(); }
    [[nodiscard]] std::vector<WorkSpan> take() { return std::move(spans_); }

private:
    bool wanted_;
    Stopwatch watch_;
    std::vector<WorkSpan> spans_;
};

}  // namespace haste
