#pragma once

#include "core/math/vec3.h"

namespace haste {

/// `direction` (pointing away from the surface) reflected about the unit normal `n`.
template <class Real>
HASTE_HD Vec3<Real> reflect(const Vec3<Real>& direction, const Vec3<Real>& n) {
    return n * (Real(2) * dot(n, direction)) - direction;
}

}  // namespace haste
