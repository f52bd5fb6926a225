#pragma once

#include "core/geometry/triangle.h"

namespace haste {

/// The fast ray-triangle intersection: Möller and Trumbore, Fast, Minimum Storage Ray/Triangle
/// Intersection, Journal of Graphics Tools 2(1), 1997. The two triangles of an edge round it each
/// in their own way, so rays can pass between them.
template <class Real>
struct MoellerTrumboreTest {
    HASTE_HD MoellerTrumboreTest(const Vec3<Real>& ray_origin, const Vec3<Real>& ray_direction)
        : origin_(ray_origin), direction_(ray_direction) {}

    /// Hits on either side with 0 < t; degenerate triangles are never hit.
    HASTE_HD PrimitiveHit<Real> hit(const Vec3<Real>& v0, const Vec3<Real>& v1,
                                    const Vec3<Real>& v2) const {
        const Vec3<Real> e1 = v1 - v0;
        const Vec3<Real> e2 = v2 - v0;
        const Vec3<Real> p = plain_cross(direction_, e2);
        const Real determinant = dot(e1, p);
        const Real inverse = Real(1) / determinant;
        const Vec3<Real> s = origin_ - v0;
        const Vec3<Real> q = plain_cross(s, e1);
        const Real b1 = dot(s, p) * inverse;
        const Real b2 = dot(direction_, q) * inverse;
        const Real t = dot(e2, q) * inverse;
        const bool inside = b1 >= Real(0) && b2 >= Real(0) && b1 + b2 <= Real(1);
        return {t, b1, b2, inside && t > Real(0) && t < Numeric<Real>::infinity};
    }

private:
    HASTE_HD static Vec3<Real> plain_cross(const Vec3<Real>& a, const Vec3<Real>& b) {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }

    Vec3<Real> origin_;
    Vec3<Real> direction_;
};

}  // namespace haste
