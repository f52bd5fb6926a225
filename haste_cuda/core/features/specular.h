#pragma once

#include "core/base/material.h"
#include "core/math/frame.h"
#include "core/model/reflection.h"
#include "core/model/scattering.h"
#include "core/sampling/phong_lobe.h"

namespace haste {

/// The paper's specular term, equation 2, of light from direction `l`.
template <class Real>
HASTE_HD Vec3<Real> specular_term(const Material<Real>& material, const Vec3<Real>& l,
                                  const Vec3<Real>& normal, const Vec3<Real>& view) {
    if (is_zero(material.specular)) return splat(Real(0));
    return material.specular * power_of_cosine(reflect(l, normal), view, material.exponent);
}

/// The Phong lobe of `path` about the mirrored view, chosen with probability `share`: Lafortune and
/// Willems, Using the Modified Phong Reflectance Model for Physically Based Rendering, 1994.
template <class Real>
HASTE_HD BsdfValue<Real> specular_lobe(const Material<Real>& material, Real share,
                                       const Vec3<Real>& view, const Vec3<Real>& normal,
                                       const Vec3<Real>& direction, Real cosine) {
    const Real inverse_pi = Real(1) / Numeric<Real>::pi;
    const Real power = power_of_cosine(reflect(view, normal), direction, material.exponent) *
                       (Real(0.5) * inverse_pi);
    return {material.specular * ((material.exponent + Real(2)) * power * cosine),
            share * (material.exponent + Real(1)) * power};
}

template <class Real>
HASTE_HD Vec3<Real> specular_direction(const Material<Real>& material, const Vec3<Real>& view,
                                       const Vec3<Real>& normal, Real u, Real v) {
    return frame_about(reflect(view, normal)).to_world(phong_lobe(u, v, material.exponent));
}

}  // namespace haste
