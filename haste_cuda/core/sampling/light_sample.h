#pragma once

#include "core/base/features.h"
#include "core/base/scene_view.h"
#include "core/math/frame.h"
#include "core/sampling/warp.h"

namespace haste {

/// A point on a mesh light and the normal there.
template <class Real>
struct LightPoint {
    Vec3<Real> point;
    Vec3<Real> normal;
    Real scale;  ///< largest absolute coordinate that took part in `point`
};

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

/// The cone that a sphere light fills, seen from a point: 1 - cos of its half angle, or 2 (the
/// whole sphere of directions, never sampled so) from inside.
template <class Real>
struct SphereCone {
    Vec3<Real> to_centre;
    Real distance_squared;
    Real one_minus_cosine;
    bool outside;

    HASTE_HD SphereCone(const Light<Real>& light, const Vec3<Real>& from)
        : to_centre(light.centre - from), distance_squared(length_squared(to_centre)) {
        const Real sine_squared = light.radius * light.radius / distance_squared;
        outside = sine_squared < Real(1);
        one_minus_cosine =
            outside ? sine_squared / (Real(1) + safe_square_root(Real(1) - sine_squared)) : Real(2);
    }

    /// Density per solid angle of a direction within the cone.
    HASTE_HD Real pdf() const { return Real(1) / (Real(2) * Numeric<Real>::pi * one_minus_cosine); }
};

/// A direction towards a light, its point there, and its density per solid angle.
template <class Real>
struct LightDirection {
    LightPoint<Real> target;
    Vec3<Real> direction;
    Real pdf;
    bool valid;
};

/// `path`: spheres by the solid angle they fill, meshes by area. From inside a sphere, by area.
/// Valid where the light's emitting side faces `from`.
template <class F, class Real>
HASTE_HD LightDirection<Real> sample_light_direction(const SceneView<Real>& scene,
                                                     const Light<Real>& light,
                                                     const Vec3<Real>& from, Real pick, Real u,
                                                     Real v) {
    LightDirection<Real> result;
    if (F::sphere_lights && (!F::mesh_lights || light.is_sphere)) {
        const bool flipped = scene.shapes[light.shape].flip_normals;
        const SphereCone<Real> cone(light, from);
        Vec3<Real> outward;
        if (cone.outside) {
            const Real distance = square_root(cone.distance_squared);
            const Vec3<Real> local = uniform_cone(u, v, cone.one_minus_cosine);
            const Frame<Real> frame = frame_about(cone.to_centre * (Real(1) / distance));
            result.direction = frame.to_world(local);
            // Not 1 - cosine^2, of which nothing is left in a narrow cone.
            const Real sine_squared = local.x * local.x + local.y * local.y;
            const Real along =
                distance * local.z - safe_square_root(light.radius * light.radius -
                                                      cone.distance_squared * sine_squared);
            outward = normalize(result.direction * along - cone.to_centre);
            result.pdf = cone.pdf();
        } else {
            outward = uniform_sphere(u, v);
            const Vec3<Real> offset = cone.to_centre + outward * light.radius;
            const Real squared = length_squared(offset);
            result.direction = offset * (Real(1) / square_root(squared));
            result.pdf = squared / (light.area * absolute(dot(outward, result.direction)));
        }
        result.target.point = light.centre + outward * light.radius;
        result.target.normal = flipped ? -outward : outward;
        result.target.scale = max_norm(light.centre) + light.radius;
    } else {
        result.target = sample_mesh_light(scene, light, pick, u, v);
        const Vec3<Real> offset = result.target.point - from;
        const Real squared = length_squared(offset);
        result.direction = offset * (Real(1) / square_root(squared));
        result.pdf = squared / (light.area * absolute(dot(result.target.normal, result.direction)));
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
    if (F::sphere_lights && (!F::mesh_lights || light.is_sphere)) {
        const SphereCone<Real> cone(light, from);
        if (cone.outside) return cone.pdf();
    }
    return t * t / (light.area * absolute(dot(normal, direction)));
}

}  // namespace haste
