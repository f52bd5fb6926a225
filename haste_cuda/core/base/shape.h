#pragma once

#include "core/config.h"

namespace haste {

inline constexpr u32 no_light = 0xffffffffu;

/// A mesh or a sphere: what its primitives have in common.
struct Shape {
    u32 material;
    u32 light;  ///< index of its light, or `no_light`
    u32 first;  ///< first triangle, or the sphere's index
    u32 count;  ///< triangles; 1 for a sphere
    u32 is_sphere;
    u32 smooth;        ///< triangles have vertex normals
    u32 flip_normals;  ///< spheres only: the normal points inwards (meshes are turned at import)
};

}  // namespace haste
