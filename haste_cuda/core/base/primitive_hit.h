#pragma once

#include "core/config.h"

namespace haste {

/// A candidate hit of one primitive.
template <class Real>
struct PrimitiveHit {
    Real t;
    Real b1, b2;
    bool found;
};

}  // namespace haste
