#pragma once

#include "core/geometry/sphere.h"
#include "core/geometry/surface.h"

namespace haste {

/// The surface where a sphere is hit.
template <class Real>
HASTE_HD Surface<Real> sphere_surface(const SceneView<Real>& scene, const Ray<Real>& ray,
                                      const Hit<Real>& hit) {
    const u32 sphere = hit.primitive - scene.triangle_count;
    const Vec3<Real> centre = scene.sphere_centre[sphere];
    const Real radius = scene.sphere_radius[sphere];
    const Vec3<Real> outward = normalize(ray.origin - centre + ray.direction * hit.t);
    Surface<Real> surface;
    surface.point = centre + outward * radius;
    surface.scale = max_norm(centre) + radius;
    surface.shape = scene.sphere_shape[sphere];
    surface.geometric_normal = scene.shapes[surface.shape].flip_normals ? -outward : outward;
    surface.shading_normal = surface.geometric_normal;
    return surface;
}

}  // namespace haste
