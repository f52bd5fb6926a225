#pragma once

#include "core/sampling/light_sample.h"
#include "core/sampling/warp.h"

namespace haste {

/// Uniform by area on a mesh light: `pick` chooses the triangle, (u, v) the point on it.
template <class Real>
HASTE_HD LightPoint<Real> sample_mesh_light(const SceneView<Real>& scene, const Light<Real>& light,
                                            Real pick, Real u, Real v) {
    const Shape& shape = scene.shapes[light.shape];
    const Real* cdf = scene.light_cdf + light.first_cdf;
    const Real target = pick * light.area;
    u32 low = 0;
    u32 high = shape.count - 1;
    while (low < high) {
        const u32 middle = (low + high) / 2;
        if (target < cdf[middle]) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    const u32* index = scene.triangles + 3 * u64(shape.first + low);
    const Vec3<Real> v0 = scene.vertices[index[0]];
    const Vec3<Real> v1 = scene.vertices[index[1]];
    const Vec3<Real> v2 = scene.vertices[index[2]];
    const Barycentrics<Real> b = uniform_triangle(u, v);
    const Vec3<Real> e1 = v1 - v0;
    const Vec3<Real> e2 = v2 - v0;
    return {v0 + (e1 * b.b1 + e2 * b.b2), normalize(cross(e1, e2)),
            maximum(max_norm(v0), maximum(max_norm(v1), max_norm(v2)))};
}

/// `path`: a direction from `from` to a point uniform by area.
template <class Real>
HASTE_HD LightDirection<Real> towards_mesh_light(const SceneView<Real>& scene,
                                                 const Light<Real>& light, const Vec3<Real>& from,
                                                 Real pick, Real u, Real v) {
    LightDirection<Real> result;
    result.target = sample_mesh_light(scene, light, pick, u, v);
    const Vec3<Real> offset = result.target.point - from;
    const Real squared = length_squared(offset);
    result.direction = offset * (Real(1) / square_root(squared));
    result.pdf = squared / (light.area * absolute(dot(result.target.normal, result.direction)));
    return result;
}

}  // namespace haste
