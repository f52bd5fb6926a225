#pragma once

#include "core/math/elementary.h"
#include "core/math/vec3.h"

namespace haste {

/// `direction` (pointing away from the surface) reflected about the unit normal `n`.
template <class Real>
HASTE_HD Vec3<Real> reflect(const Vec3<Real>& direction, const Vec3<Real>& n) {
    return n * (Real(2) * dot(n, direction)) - direction;
}

/// Snell's law at one point.
template <class Real>
struct Refraction {
    Vec3<Real> direction{};
    Real cosine_incident = 0;
    Real cosine_transmitted = 0;
    bool total = false;  ///< total internal reflection: there is no direction
};

/// Refraction of `view` (unit, pointing away) at `n`, turned to the viewer's side; `eta` is the
/// index on the viewer's side over the index beyond. A grazing view past an interpolated normal is
/// clamped.
template <class Real>
HASTE_HD Refraction<Real> refract(const Vec3<Real>& view, const Vec3<Real>& n, Real eta) {
    const Real c = maximum(dot(n, view), Real(0));
    const Real k = Real(1) - eta * eta * (Real(1) - c * c);
    if (k < Real(0)) return {n, c, Real(0), true};
    const Real root = square_root(k);
    return {n * (eta * c - root) - view * eta, c, root, false};
}

/// Exact Fresnel reflectance of unpolarised light at a smooth dielectric (Born and Wolf, 1.5.2);
/// `eta` as in `refract`. Total internal reflection gives 1.
template <class Real>
HASTE_HD Real fresnel_dielectric(const Refraction<Real>& refraction, Real eta) {
    const Real ci = refraction.cosine_incident;
    if (refraction.total || ci == Real(0)) return Real(1);
    const Real ct = refraction.cosine_transmitted;
    const Real perpendicular = (eta * ci - ct) / (eta * ci + ct);
    const Real parallel = (ci - eta * ct) / (ci + eta * ct);
    return Real(0.5) * (perpendicular * perpendicular + parallel * parallel);
}

/// max(0, cos)^exponent for the angle between two unit vectors, through 1 - cos = |a - b|^2 / 2,
/// which keeps its digits near the peak of a sharp lobe, where the cosine has lost them.
template <class Real>
HASTE_HD Real power_of_cosine(const Vec3<Real>& a, const Vec3<Real>& b, Real exponent) {
    const Real one_minus_cosine = Real(0.5) * length_squared(a - b);
    if (one_minus_cosine >= Real(1)) return Real(0);
    return exponential(exponent * logarithm_of_one_plus(-one_minus_cosine));
}

}  // namespace haste
