#pragma once

#include "core/geometry/surface.h"

namespace haste {

/// Turns the shading normal to that of the vertices, weighed by barycentrics, where the shape has
/// such normals (Phong, Illumination for Computer Generated Pictures, CACM 18(6), 1975).
template <class Real>
HASTE_HD void interpolate_normal(const SceneView<Real>& scene, const Hit<Real>& hit,
                                 const u32* index, Surface<Real>& surface) {
    if (!scene.shapes[surface.shape].smooth) return;
    const Vec3<Real> n = scene.normals[index[0]] * (Real(1) - hit.b1 - hit.b2) +
                         scene.normals[index[1]] * hit.b1 + scene.normals[index[2]] * hit.b2;
    const Real squared = length_squared(n);
    if (squared > Real(0)) surface.shading_normal = n * (Real(1) / square_root(squared));
}

}  // namespace haste
