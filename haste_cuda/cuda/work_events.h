#pragma once

#include <vector>

#include "cuda/event.h"
#include "engine/schedule_work.h"

namespace haste::cuda {

/// Notes when work in streams began and ended, by the device's clock, where that is asked for:
/// marks take time of their own.
class WorkEvents {
public:
    explicit WorkEvents(bool wanted) : wanted_(wanted) {}

    /// The beginning from which all times count. Waits for it, so that no other stream begins
    /// earlier.
    void start(const Stream& stream) {
        marks_.clear();
        if (!wanted_) return;
        start_.record(stream);
        start_.synchronize();
    }

    /// Gives work to a stream between two marks.
    template <class Work>
    void time(WorkKind kind, u32 lane, u64 rays, const Stream& stream, Work&& work) {
        if (!wanted_) {
            work();
            return;
        }
        marks_.push_back({kind, lane, rays, {}, {}});
        marks_.back().begin.record(stream);
        work();
        marks_.back().end.record(stream);
    }

    /// Waits for all of it.
    [[nodiscard]] std::vector<WorkSpan> spans() const {
        std::vector<WorkSpan> spans;
        for (const Mark& mark : marks_) {
            const double end = seconds_between(start_, mark.end);
            spans.push_back(
                {mark.kind, mark.lane, seconds_between(start_, mark.begin), end, mark.rays});
        }
        return spans;
    }

private:
    struct Mark {
        WorkKind kind;
        u32 lane;
        u64 rays;
        Event begin;
        Event end;
    };

    bool wanted_;
    Event start_;
    std::vector<Mark> marks_;
};

}  // namespace haste::cuda
