#pragma once

#include "core/base/ray.h"

namespace haste {

/// Live rays by class. A ray is counted once, where it is traced.
struct RayCounts {
    u64 camera = 0, shadow = 0, ambient = 0, bounce = 0;

    HASTE_HD RayCounts& operator+=(const RayCounts& other) {
        camera += other.camera;
        shadow += other.shadow;
        ambient += other.ambient;
        bounce += other.bounce;
        return *this;
    }

    template <class Real>
    HASTE_HD void count(const Ray<Real>& ray) {
        if (ray.flags & single_bounce) {
            ++ambient;
        } else if (ray.layer == 0) {
            ++camera;
        } else {
            ++bounce;
        }
    }
};

}  // namespace haste
