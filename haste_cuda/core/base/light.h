#pragma once

#include "core/math/vec3.h"

namespace haste {

/// A shape that emits: `radiance` is the paper's k_e i_e.
template <class Real>
struct Light {
    Vec3<Real> radiance;
    u32 shape;
    Vec3<Real> centroid;  ///< a sphere's centre, a mesh's area-weighted triangle centroid
    Real area;
    Vec3<Real> centre;  ///< of a sphere
    Real radius;        ///< of a sphere, 0 for a mesh
    u32 first_cdf;      ///< of a mesh: its slice of the cumulated areas
    u32 is_sphere;
};

}  // namespace haste
