#pragma once

#include "core/base/features.h"
#include "core/base/hit.h"
#include "core/base/ray.h"
#include "core/base/scene_view.h"

namespace haste {

/// A point on a surface, rebuilt from barycentrics or by projection rather than from origin + t
/// direction, so that its error does not grow with the length of the ray.
template <class Real>
struct Surface {
    Vec3<Real> point;
    Vec3<Real> geometric_normal;  ///< mesh winding, spheres outwards unless flipped
    Vec3<Real> shading_normal;  ///< interpolated; the geometric normal where a shape is not smooth
    Real scale;                 ///< largest absolute coordinate that took part in `point`
    u32 shape;
};

template <class F, class Real>
HASTE_HD Surface<Real> surface_at(const SceneView<Real>& scene, const Ray<Real>& ray,
                                  const Hit<Real>& hit) {
    if constexpr (F::spheres && F::triangles) {
        return hit.primitive < scene.triangle_count ? triangle_surface(F(), scene, hit)
                                                    : sphere_surface(scene, ray, hit);
    } else if constexpr (F::spheres) {
        return sphere_surface(scene, ray, hit);
    } else {
        return triangle_surface(F(), scene, hit);
    }
}

}  // namespace haste
