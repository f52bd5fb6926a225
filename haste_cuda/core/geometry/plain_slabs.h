#pragma once

#include "core/base/bvh2.h"
#include "core/math/vec3.h"

namespace haste {

/// Ray against box by slabs as Kay and Kajiya, Ray Tracing Complex Scenes, SIGGRAPH 1986, have
/// them: not padded, so boxes that hold a hit can be missed by rounding.
template <class Real>
struct PlainSlabTest {
    HASTE_HD PlainSlabTest(const Vec3<Real>& ray_origin, const Vec3<Real>& direction, const Box&)
        : origin_(ray_origin),
          inverse_{Real(1) / direction.x, Real(1) / direction.y, Real(1) / direction.z} {}

    /// Distance at which the ray enters the box, t_min if it starts inside, or infinity where it
    /// misses (t_min, t_max]. Along an axis that the ray starts on a slab of and has no slope in,
    /// 0 times infinity clips nothing.
    HASTE_HD Real enter(const Box& box, Real t_min, Real t_max) const {
        Real near = t_min;
        Real far = t_max;
        clip(box.lower[0], box.upper[0], origin_.x, inverse_.x, near, far);
        clip(box.lower[1], box.upper[1], origin_.y, inverse_.y, near, far);
        clip(box.lower[2], box.upper[2], origin_.z, inverse_.z, near, far);
        return near <= far ? near : Numeric<Real>::infinity;
    }

private:
    HASTE_HD static void clip(float lower, float upper, Real origin, Real inverse, Real& near,
                              Real& far) {
        const bool backwards = inverse < Real(0);
        const Real entry = (Real(backwards ? upper : lower) - origin) * inverse;
        const Real exit = (Real(backwards ? lower : upper) - origin) * inverse;
        near = number_maximum(entry, near);
        far = number_minimum(exit, far);
    }

    Vec3<Real> origin_;
    Vec3<Real> inverse_;
};

}  // namespace haste
