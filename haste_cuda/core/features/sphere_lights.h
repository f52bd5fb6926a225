#pragma once

#include "core/math/frame.h"
#include "core/sampling/light_sample.h"
#include "core/sampling/warp.h"

namespace haste {

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

/// `path`: a direction from `from` uniform in the cone, from inside to a point uniform by area.
template <class Real>
HASTE_HD LightDirection<Real> towards_sphere_light(const SceneView<Real>& scene,
                                                   const Light<Real>& light, const Vec3<Real>& from,
                                                   Real u, Real v) {
    LightDirection<Real> result;
    const bool flipped = scene.shapes[light.shape].flip_normals;
    const SphereCone<Real> cone(light, from);
    Vec3<Real> outward;
    if (cone.outside) {
        const Real distance = square_root(cone.distance_squared);
        const Vec3<Real> local = uniform_cone(u, v, cone.one_minus_cosine);
        const Frame<Real> frame = frame_about(cone.to_centre * (Real(1) / distance));
        result.direction = frame.to_world(local);
        const Real sine_squared = maximum(Real(1) - local.z * local.z, Real(0));
        const Real along =
            distance * local.z -
            safe_square_root(light.radius * light.radius - cone.distance_squared * sine_squared);
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
    return result;
}

/// Density of a direction to a sphere light per solid angle; 0 from inside, where it depends on the
/// point.
template <class Real>
HASTE_HD Real sphere_light_pdf(const Light<Real>& light, const Vec3<Real>& from) {
    const SphereCone<Real> cone(light, from);
    return cone.outside ? cone.pdf() : Real(0);
}

/// `haste`: a point in the volume of a sphere light, or on its surface.
template <class Real>
HASTE_HD Vec3<Real> point_in_sphere_light(const Light<Real>& light, bool on_surface, Real u, Real v,
                                          Real w) {
    return light.centre +
           (on_surface ? uniform_sphere(u, v) : uniform_ball(u, v, w)) * light.radius;
}

}  // namespace haste
