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
HASTE_HD Surface<Real> triangle_surface(const SceneView<Real>& scene, const Hit<Real>& hit) {
    const u32* index = scene.triangles + 3 * u64(hit.primitive);
    const Vec3<Real> v0 = scene.vertices[index[0]];
    const Vec3<Real> v1 = scene.vertices[index[1]];
    const Vec3<Real> v2 = scene.vertices[index[2]];
    const Vec3<Real> e1 = v1 - v0;
    const Vec3<Real> e2 = v2 - v0;
    Surface<Real> surface;
    surface.point = v0 + (e1 * hit.b1 + e2 * hit.b2);
    surface.scale = maximum(max_norm(v0), maximum(max_norm(v1), max_norm(v2)));
    surface.shape = scene.triangle_shape[hit.primitive];
    surface.geometric_normal = normalize(cross(e1, e2));
    surface.shading_normal = surface.geometric_normal;
    if constexpr (F::smooth_normals) {
        if (scene.shapes[surface.shape].smooth) {
            const Vec3<Real> n = scene.normals[index[0]] * (Real(1) - hit.b1 - hit.b2) +
                                 scene.normals[index[1]] * hit.b1 +
                                 scene.normals[index[2]] * hit.b2;
            const Real squared = length_squared(n);
            if (squared > Real(0)) surface.shading_normal = n * (Real(1) / square_root(squared));
        }
    }
    return surface;
}

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

template <class F, class Real>
HASTE_HD Surface<Real> surface_at(const SceneView<Real>& scene, const Ray<Real>& ray,
                                  const Hit<Real>& hit) {
    if constexpr (F::spheres && F::triangles) {
        return hit.primitive < scene.triangle_count ? triangle_surface<F>(scene, hit)
                                                    : sphere_surface(scene, ray, hit);
    } else if constexpr (F::spheres) {
        return sphere_surface(scene, ray, hit);
    } else {
        return triangle_surface<F>(scene, hit);
    }
}

}  // namespace haste
