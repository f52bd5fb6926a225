#pragma once

#include "core/base/material.h"
#include "core/model/reflection.h"

namespace haste {

/// The share R that a Phong surface mirrors, equation 9.
template <class Real>
HASTE_HD Real mirrored_share(const Material<Real>& material) {
    return material.reflection;
}

}  // namespace haste
