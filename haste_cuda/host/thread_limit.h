#pragma once

#include <tbb/global_control.h>

#include <optional>

namespace haste {

/// While it lives, TBB (and Embree, which builds with it) works with this many threads at most;
/// with all for 0.
class ThreadLimit {
public:
    explicit ThreadLimit(int threads) {
        if (threads > 0) {
            control_.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
        }
    }

private:
    std::optional<tbb::global_control> control_;
};

}  // namespace haste
