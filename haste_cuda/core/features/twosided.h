#pragma once

#include "core/base/material.h"

namespace haste {

/// `path`: whether the lobes in front are on the back of the surface as well.
template <class Real>
HASTE_HD bool reflects_behind(const Material<Real>& material) {
    return material.twosided;
}

}  // namespace haste
