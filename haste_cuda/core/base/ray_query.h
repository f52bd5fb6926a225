#pragma once

#include "core/base/hit.h"
#include "core/math/vec3.h"

namespace haste {

/// A ray that carries nothing: where does it hit within (t_min, t_max]? Distances are in units of
/// its direction, which need not have unit length.
template <class Real>
struct RayQuery {
    Vec3<Real> origin;
    Real t_min;
    Vec3<Real> direction;
    Real t_max;
};

static_assert(sizeof(RayQuery<float>) == 32, "two 16-byte loads");

/// The answer. A query for any hit is told whether, not where: t is then 0 or infinity.
template <class Real>
struct QueryHit {
    Real t;
    u32 primitive;  ///< `no_primitive` without a hit, and of a query for any hit
};

}  // namespace haste
