#pragma once

#include "core/math/numeric.h"

namespace haste {

inline constexpr u32 no_primitive = 0xffffffffu;

/// The closest hit of a ray: triangles count from 0, spheres follow them.
template <class Real>
struct Hit {
    Real t = Numeric<Real>::infinity;  ///< in units of the ray's direction
    Real b1 = 0, b2 = 0;               ///< barycentrics of the second and third vertex
    u32 primitive = no_primitive;

    HASTE_HD bool found() const { return primitive != no_primitive; }

    /// Closest hit = least (t, primitive): the order of traversal never shows.
    HASTE_HD bool loses_to(Real other_t, u32 other_primitive) const {
        return other_t < t || (other_t == t && other_primitive < primitive);
    }
};

}  // namespace haste
