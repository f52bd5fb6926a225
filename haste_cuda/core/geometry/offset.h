#pragma once

#include "core/math/vec3.h"

namespace haste {

/// Starts a spawned ray off its surface by the error of the point it starts from and of the test
/// that could find the surface again, and no further: no absolute constant, so it is free of scale.
template <class Real>
struct ErrorBoundedOffset {
    /// `scale`: the largest absolute coordinate that took part in computing the point. Point, edge
    /// differences and the sheared depths of the test each carry a few rounded operations on it.
    HASTE_HD static Vec3<Real> apply(const Vec3<Real>& point, const Vec3<Real>& normal, Real scale,
                                     const Vec3<Real>& direction) {
        const Real distance = gamma_bound<Real>(16) * scale;
        return point + normal * (dot(normal, direction) < Real(0) ? -distance : distance);
    }
};

}  // namespace haste
