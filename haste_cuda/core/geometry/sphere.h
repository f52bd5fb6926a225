#pragma once

#include "core/base/primitive_hit.h"
#include "core/math/vec3.h"

namespace haste {

/// Ray against sphere without the cancellation of the textbook quadratic: Haines, Günther and
/// Akenine-Möller, Precision Improvements for Ray/Sphere Intersection, Ray Tracing Gems, chapter 7.
/// Directions need not have unit length. Hits beyond t_min: the far side where the near one is not.
template <class Real>
HASTE_HD PrimitiveHit<Real> intersect_sphere(const Vec3<Real>& origin, const Vec3<Real>& direction,
                                             const Vec3<Real>& centre, Real radius, Real t_min) {
    const Vec3<Real> f = origin - centre;
    const Real a = dot(direction, direction);
    const Real b = -dot(f, direction);
    const Vec3<Real> closest = f + direction * (b / a);
    const Real discriminant = radius * radius - dot(closest, closest);
    if (!(discriminant >= Real(0))) return {Real(0), Real(0), Real(0), false};
    const Real root = square_root(a * discriminant);
    const Real q = b < Real(0) ? b - root : b + root;
    const Real c = dot(f, f) - radius * radius;
    const Real first = q == Real(0) ? Real(0) : c / q;
    const Real second = q / a;
    const Real near = minimum(first, second);
    const Real far = maximum(first, second);
    const Real t = near > t_min ? near : far;
    return {t, Real(0), Real(0), t > t_min && t < Numeric<Real>::infinity};
}

}  // namespace haste
