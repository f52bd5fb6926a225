#pragma once

#include "core/base/material.h"
#include "core/model/refraction.h"

namespace haste {

/// Whether a Phong surface refracts: the share R of equation 9.
template <class Real>
HASTE_HD bool transmits(const Material<Real>& material) {
    return material.transmission > Real(0);
}

}  // namespace haste
