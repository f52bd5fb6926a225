#pragma once

#include <span>
#include <vector>

#include "core/base/ray_query.h"

namespace haste {

/// Rays that make sense: they are checked once, however often they are traced.
class RayBatch {
public:
    /// Throws std::invalid_argument naming the first ray that is not finite, or whose interval
    /// (t_min, t_max] is not one of distances.
    explicit RayBatch(std::vector<RayQuery<float>> queries);

    [[nodiscard]] std::span<const RayQuery<float>> queries() const { return queries_; }
    [[nodiscard]] std::size_t size() const { return queries_.size(); }

private:
    std::vector<RayQuery<float>> queries_;
};

}  // namespace haste
