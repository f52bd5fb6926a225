#pragma once

#include "core/math/vec3.h"

namespace haste {

/// An orthonormal frame about a unit normal.
template <class Real>
struct Frame {
    Vec3<Real> s, t, n;

    HASTE_HD Vec3<Real> to_world(const Vec3<Real>& local) const {
        return s * local.x + t * local.y + n * local.z;
    }
};

/// Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017: no singular direction.
template <class Real>
HASTE_HD Frame<Real> frame_about(const Vec3<Real>& n) {
    const Real sign = n.z < Real(0) ? Real(-1) : Real(1);
    const Real a = Real(-1) / (sign + n.z);
    const Real b = n.x * n.y * a;
    return {{Real(1) + sign * n.x * n.x * a, sign * b, -sign * n.x},
            {b, sign + n.y * n.y * a, -n.y},
            n};
}

}  // namespace haste
