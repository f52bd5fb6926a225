#pragma once

#include "core/math/elementary.h"
#include "core/math/trigonometry.h"
#include "core/math/vec3.h"

namespace haste {

/// Uniform on the unit sphere, by Archimedes' projection.
template <class Real>
HASTE_HD Vec3<Real> uniform_sphere(Real u, Real v) {
    const Real z = Real(1) - Real(2) * u;
    const Real radius = Real(2) * safe_square_root(u * (Real(1) - u));
    const SinCos<Real> phi = sin_cos_of_turn(v);
    return {radius * phi.cosine, radius * phi.sine, z};
}

/// Uniform on the hemisphere about +z: density 1 / (2 pi).
template <class Real>
HASTE_HD Vec3<Real> uniform_hemisphere(Real u, Real v) {
    const Real radius = safe_square_root(u * (Real(2) - u));
    const SinCos<Real> phi = sin_cos_of_turn(v);
    return {radius * phi.cosine, radius * phi.sine, Real(1) - u};
}

/// Cosine-distributed on the hemisphere about +z: density z / pi.
template <class Real>
HASTE_HD Vec3<Real> cosine_hemisphere(Real u, Real v) {
    const Real radius = square_root(u);
    const SinCos<Real> phi = sin_cos_of_turn(v);
    return {radius * phi.cosine, radius * phi.sine, square_root(Real(1) - u)};
}

/// Uniform in the unit ball: the paper's points in the volume of a light.
template <class Real>
HASTE_HD Vec3<Real> uniform_ball(Real u, Real v, Real w) {
    return uniform_sphere(u, v) * cube_root(w);
}

/// Uniform in the cone about +z of which `one_minus_cosine` = 1 - cos(theta_max): density
/// 1 / (2 pi one_minus_cosine). Written in 1 - cos, which keeps its digits for narrow cones.
template <class Real>
HASTE_HD Vec3<Real> uniform_cone(Real u, Real v, Real one_minus_cosine) {
    const Real c = u * one_minus_cosine;
    const Real radius = safe_square_root(c * (Real(2) - c));
    const SinCos<Real> phi = sin_cos_of_turn(v);
    return {radius * phi.cosine, radius * phi.sine, Real(1) - c};
}

/// Barycentrics (b1, b2) uniform by area on a triangle.
template <class Real>
struct Barycentrics {
    Real b1, b2;
};

template <class Real>
HASTE_HD Barycentrics<Real> uniform_triangle(Real u, Real v) {
    const Real root = square_root(u);
    return {Real(1) - root, v * root};
}

}  // namespace haste
