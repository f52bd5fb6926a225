#pragma once

#include "core/math/vec3.h"

namespace haste {

/// A candidate hit of one primitive.
template <class Real>
struct PrimitiveHit {
    Real t;
    Real b1, b2;
    bool found;
};

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
        const u32 main = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
        const u32 next = main == 2 ? 0 : main + 1;
        const u32 last = 3 - main - next;
        const bool swap = pick(direction, main) < Real(0);
        axes_ = (swap ? last | next << 2 : next | last << 2) | main << 4;
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
    /// Without a branch, for the rays of a warp differ here.
    HASTE_HD static Real pick(const Vec3<Real>& p, u32 axis) {
        const Real x_or_y = axis == 0 ? p.x : p.y;
        return axis == 2 ? p.z : x_or_y;
    }

    /// Moves the axis of the largest direction component to z; the others follow it, in the order
    /// that keeps a triangle's winding.
    HASTE_HD Vec3<Real> permute(const Vec3<Real>& p) const {
        return {pick(p, axes_ & 3), pick(p, (axes_ >> 2) & 3), pick(p, axes_ >> 4)};
    }

    /// A vertex in the ray's own coordinates: a function of vertex and ray alone, whichever slot of
    /// whichever triangle it comes from.
    HASTE_HD Vec3<Real> shear(const Vec3<Real>& vertex) const {
        const Vec3<Real> p = permute(vertex - origin_);
        return {fma(-shear_x_, p.z, p.x), fma(-shear_y_, p.z, p.y), shear_z_ * p.z};
    }

    Vec3<Real> origin_;
    Real shear_x_, shear_y_, shear_z_;
    u32 axes_;  ///< which axis becomes x, y and z, two bits each
};

}  // namespace haste
