#pragma once

#include "core/base/features.h"
#include "core/base/scene_view.h"

namespace haste {

/// A point on a light and the normal there.
template <class Real>
struct LightPoint {
    Vec3<Real> point;
    Vec3<Real> normal;
    Real scale;  ///< largest absolute coordinate that took part in `point`
};

/// A direction towards a light, its point there, and its density per solid angle.
template <class Real>
struct LightDirection {
    LightPoint<Real> target;
    Vec3<Real> direction;
    Real pdf;
    bool valid;
};

/// Whether a light is a sphere: known beforehand where all lights are of one kind.
template <class F, class Real>
HASTE_HD bool is_sphere_light(const Light<Real>& light) {
    return F::sphere_lights && (!F::mesh_lights || light.is_sphere);
}

/// `path`: spheres by the solid angle they fill, meshes by area. From inside a sphere, by area.
/// Valid where the light's emitting side faces `from`.
template <class F, class Real>
HASTE_HD LightDirection<Real> sample_light_direction(const SceneView<Real>& scene,
                                                     const Light<Real>& light,
                                                     const Vec3<Real>& from, Real pick, Real u,
                                                     Real v) {
    LightDirection<Real> result;
    if (is_sphere_light<F>(light)) {
        if constexpr (F::sphere_lights) result = towards_sphere_light(scene, light, from, u, v);
    } else {
        if constexpr (F::mesh_lights) result = towards_mesh_light(scene, light, from, pick, u, v);
    }
    result.valid = dot(result.target.normal, result.direction) < Real(0) &&
                   result.pdf < Numeric<Real>::infinity;
    return result;
}

/// Density with which `sample_light_direction` from `from` would have found the point hit at
/// distance `t` along unit `direction`, where the light's geometric normal is `normal`.
template <class F, class Real>
HASTE_HD Real light_direction_pdf(const Light<Real>& light, const Vec3<Real>& from,
                                  const Vec3<Real>& direction, const Vec3<Real>& normal, Real t) {
    if constexpr (F::sphere_lights) {
        if (is_sphere_light<F>(light)) {
            const Real pdf = sphere_light_pdf(light, from);
            if (pdf > Real(0)) return pdf;
        }
    }
    return t * t / (light.area * absolute(dot(normal, direction)));
}

}  // namespace haste
