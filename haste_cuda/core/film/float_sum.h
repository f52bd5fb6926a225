#pragma once

#include "core/film/fixed_point.h"
#include "core/math/vec3.h"

namespace haste {

/// The paper's film: single-precision sums, added atomically in whatever order they come. What a
/// `FilmSum` of integers is measured against.
struct FloatSum {
    float channel[3] = {0, 0, 0};
    u32 non_finite = 0;

    template <class Real>
    HASTE_HD void add(const FixedPoint&, const Vec3<Real>& value, u32) {
        const float component[3] = {float(value.x), float(value.y), float(value.z)};
        for (const float c : component) {
            // Infinity and NaN alone are not less than infinity in magnitude.
            if (!(absolute(c) < Numeric<float>::infinity)) {
                ++non_finite;
                return;
            }
        }
        for (int c = 0; c < 3; ++c) channel[c] += component[c];
    }
};

}  // namespace haste
