#include "cpu/ray_batch.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace haste {

namespace {

bool finite(const Vec3<float>& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

[[noreturn]] void refuse(std::size_t ray, const char* what) {
    throw std::invalid_argument("ray " + std::to_string(ray) + ": " + what);
}

}  // namespace

RayBatch::RayBatch(std::vector<RayQuery<float>> queries) : queries_(std::move(queries)) {
    for (std::size_t i = 0; i < queries_.size(); ++i) {
        const RayQuery<float>& query = queries_[i];
        if (!finite(query.origin)) refuse(i, "its origin is not finite");
        if (!finite(query.direction)) refuse(i, "its direction is not finite");
        if (is_zero(query.direction)) refuse(i, "its direction is zero");
        if (!(query.t_min >= 0) || std::isinf(query.t_min)) {
            refuse(i, "t_min must be finite and not negative");
        }
        if (!(query.t_max >= query.t_min)) refuse(i, "t_max must not be below t_min");
    }
}

}  // namespace haste
