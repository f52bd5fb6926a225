#pragma once

#include "core/base/material.h"
#include "core/model/reflection.h"
#include "core/model/refraction.h"

namespace haste {

template <class Real>
HASTE_HD bool is_dielectric(const Material<Real>& material) {
    return material.kind == MaterialKind::dielectric;
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

}  // namespace haste
