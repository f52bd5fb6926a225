#pragma once

#include "core/base/primitive_hit.h"
#include "core/math/vec3.h"

namespace haste {

/// Watertight ray-triangle intersection: Woop, Benthin and Wald, JCGT 2(1), 2013, with the edge
/// functions evaluated by compensated products in place of the double-precision fallback.
/// What depends on the ray alone is computed once a ray.
template <class Real>
struct WoopTest {
    HASTE_HD WoopTest(const Vec3<Real>& ray_origin, const Vec3<Real>& direction)
        : origin_(ray_origin) {
        const Real x = absolute(direction.x);
        const Real y = absolute(direction.y);
        const Real z = absolute(direction.z);
        main_is_x_ = x > y && x > z;
        main_is_y_ = !main_is_x_ && y > z;
        const Vec3<Real> d = permute(direction);
        shear_z_ = Real(1) / d.z;
        shear_x_ = d.x * shear_z_;
        shear_y_ = d.y * shear_z_;
    }

    /// Hits on either side with 0 < t; degenerate triangles are never hit.
    HASTE_HD PrimitiveHit<Real> hit(const Vec3<Real>& v0, const Vec3<Real>& v1,
                                    const Vec3<Real>& v2) const {
        const Vec3<Real> a = shear(v0);
        const Vec3<Real> b = shear(v1);
        const Vec3<Real> c = shear(v2);
        const Real u = difference_of_products(c.x, b.y, c.y, b.x);
        const Real v = difference_of_products(a.x, c.y, a.y, c.x);
        const Real w = difference_of_products(b.x, a.y, b.y, a.x);
        const bool some_negative = u < Real(0) || v < Real(0) || w < Real(0);
        const bool some_positive = u > Real(0) || v > Real(0) || w > Real(0);
        const Real determinant = u + v + w;
        if ((some_negative && some_positive) || determinant == Real(0)) {
            return {Real(0), Real(0), Real(0), false};
        }
        const Real inverse = Real(1) / determinant;
        const Real t = (u * a.z + v * b.z + w * c.z) * inverse;
        return {t, v * inverse, w * inverse, t > Real(0) && t < Numeric<Real>::infinity};
    }

private:
    /// Swaps the axis of the largest direction component with z, without a branch, for the rays of
    /// a warp differ here. A swap turns every winding round, and so the signs of u, v and w, of
    /// which only the comparison matters.
    HASTE_HD Vec3<Real> permute(const Vec3<Real>& p) const {
        const Real y_or_z = main_is_y_ ? p.y : p.z;
        return {main_is_x_ ? p.z : p.x, main_is_y_ ? p.z : p.y, main_is_x_ ? p.x : y_or_z};
    }

    /// A vertex in the ray's own coordinates: a function of vertex and ray alone, whichever slot of
    /// whichever triangle it comes from.
    HASTE_HD Vec3<Real> shear(const Vec3<Real>& vertex) const {
        const Vec3<Real> p = permute(vertex - origin_);
        return {fma(-shear_x_, p.z, p.x), fma(-shear_y_, p.z, p.y), shear_z_ * p.z};
    }

    Vec3<Real> origin_;
    Real shear_x_, shear_y_, shear_z_;
    bool main_is_x_, main_is_y_;
};

}  // namespace haste
