#pragma once

#include "core/geometry/moeller_trumbore.h"
#include "core/geometry/surface.h"
#include "core/geometry/triangle.h"

namespace haste {

/// The surface where a triangle is hit.
template <class F, class Real>
HASTE_HD Surface<Real> triangle_surface(F, const SceneView<Real>& scene, const Hit<Real>& hit) {
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
    if constexpr (F::smooth_normals) interpolate_normal(scene, hit, index, surface);
    return surface;
}

}  // namespace haste
