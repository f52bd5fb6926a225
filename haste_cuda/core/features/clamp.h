#pragma once

#include "core/math/vec3.h"

namespace haste {

/// A contribution scaled down to the sum of channels that the settings allow to light which has
/// met two surfaces or more, as renderers do against fireflies (Cycles, `film_clamp_light`).
template <class Real>
HASTE_HD Vec3<Real> clamp_sum(const Vec3<Real>& value, Real most) {
    const Real sum = value.x + value.y + value.z;
    return sum > most ? value * (most / sum) : value;
}

}  // namespace haste
