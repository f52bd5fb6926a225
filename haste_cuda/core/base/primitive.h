#pragma once

#include "core/math/vec3.h"

namespace haste {

/// What a leaf of the BVH tests: a triangle's vertices, or a sphere's centre (v0) and radius
/// (v1.x). Vertices, not edges: the two triangles of an edge must see the same numbers to be
/// watertight.
template <class Real>
struct alignas(16) PrimitiveRecord {
    Vec3<Real> v0, v1, v2;
    u32 primitive;  ///< triangles count from 0, spheres follow them
    u32 shape;
    u32 is_sphere;
};

static_assert(sizeof(PrimitiveRecord<float>) == 48, "three 16-byte loads");

}  // namespace haste
