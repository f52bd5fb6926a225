#pragma once

#include "core/math/vec3.h"

namespace haste {

/// A pinhole camera whose rays start on the near plane.
/// The direction through film position (x, y) in pixels, y down, is corner + x dx + y dy; its
/// component along the view axis is 1 before it is normalised.
template <class Real>
struct Camera {
    Vec3<Real> origin, corner, dx, dy;
    Real near_clip;
    u32 width, height;
};

}  // namespace haste
