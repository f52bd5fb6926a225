#pragma once

#include "core/base/material.h"
#include "core/math/frame.h"
#include "core/model/scattering.h"
#include "core/sampling/warp.h"

namespace haste {

/// The paper's diffuse term, equation 2: what a light at this cosine from the normal adds.
template <class Real>
HASTE_HD Vec3<Real> diffuse_term(const Material<Real>& material, Real cosine) {
    return material.diffuse * cosine;
}

/// The diffuse lobe of `path`, chosen with probability `share`.
template <class Real>
HASTE_HD BsdfValue<Real> diffuse_lobe(const Material<Real>& material, Real share, Real cosine) {
    const Real inverse_pi = Real(1) / Numeric<Real>::pi;
    return {material.diffuse * (cosine * inverse_pi), share * cosine * inverse_pi};
}

template <class Real>
HASTE_HD Vec3<Real> diffuse_direction(const Vec3<Real>& normal, Real u, Real v) {
    return frame_about(normal).to_world(cosine_hemisphere(u, v));
}

}  // namespace haste
