#pragma once

#include "core/base/scene_view.h"
#include "core/sampling/warp.h"

namespace haste {

template <class Real>
HASTE_HD bool has_environment(const SceneView<Real>& scene) {
    return !is_zero(scene.environment);
}

/// A direction to the environment, which is as bright in all: uniform on the sphere.
template <class Real>
HASTE_HD Vec3<Real> environment_direction(const SceneView<Real>&, Real u, Real v) {
    return uniform_sphere(u, v);
}

/// The density of `environment_direction` per solid angle.
template <class Real>
HASTE_HD Real environment_pdf(const SceneView<Real>&) {
    return Real(1) / (Real(4) * Numeric<Real>::pi);
}

}  // namespace haste
