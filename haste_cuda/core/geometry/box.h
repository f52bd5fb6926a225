#pragma once

#include "core/base/bvh2.h"
#include "core/math/vec3.h"

namespace haste {

/// Ray against box by slabs, padded so that no box that holds a hit is missed:
/// Ize, Robust BVH Ray Traversal, JCGT 2(2), 2013.
template <class Real>
struct PaddedSlabTest {
    Vec3<Real> origin;
    Vec3<Real> inverse_direction;
    Vec3<Real> padded_inverse;

    HASTE_HD PaddedSlabTest(const Vec3<Real>& ray_origin, const Vec3<Real>& direction)
        : origin(ray_origin),
          inverse_direction{Real(1) / direction.x, Real(1) / direction.y, Real(1) / direction.z},
          padded_inverse(inverse_direction * (Real(1) + Real(2) * gamma_bound<Real>(3))) {}

    /// Distance at which the ray enters the box, t_min if it starts inside, or infinity where it
    /// misses (t_min, t_max].
    /// A direction component of zero gives infinite slabs, or NaN where the origin lies on a face;
    /// the order of the arguments of minimum and maximum makes NaN no constraint.
    HASTE_HD Real enter(const Box& box, Real t_min, Real t_max) const {
        Real near = t_min;
        Real far = t_max;
        clip(box.lower[0], box.upper[0], origin.x, inverse_direction.x, padded_inverse.x, near,
             far);
        clip(box.lower[1], box.upper[1], origin.y, inverse_direction.y, padded_inverse.y, near,
             far);
        clip(box.lower[2], box.upper[2], origin.z, inverse_direction.z, padded_inverse.z, near,
             far);
        return near <= far ? near : Numeric<Real>::infinity;
    }

private:
    HASTE_HD static void clip(float lower, float upper, Real origin, Real inverse, Real padded,
                              Real& near, Real& far) {
        const bool backwards = inverse < Real(0);
        const Real entry = (Real(backwards ? upper : lower) - origin) * inverse;
        const Real exit = (Real(backwards ? lower : upper) - origin) * padded;
        near = number_maximum(entry, near);
        far = number_minimum(exit, far);
    }
};

}  // namespace haste
