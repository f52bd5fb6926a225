#pragma once

#include "core/model/scattering.h"

namespace haste {

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

/// `path`: makes the refracted direction the sample of a delta lobe.
template <class Real>
HASTE_HD void take_refracted(const Refraction<Real>& refraction, Real eta, Real inverse_total,
                             BsdfSample<Real>& sample) {
    sample.direction = normalize(refraction.direction);
    // Radiance is squeezed into, or spread out of, the denser side's smaller solid angle. The share
    // chosen with is material.transmission or 1 - F, so only that factor stays.
    sample.weight = splat(eta * eta / inverse_total);
    sample.eta = Real(1) / eta;
    sample.valid = true;
}

}  // namespace haste
