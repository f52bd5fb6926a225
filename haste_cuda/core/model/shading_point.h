#pragma once

#include "core/geometry/surface.h"

namespace haste {

/// The point that `haste` and `whitted` shade, with its normals turned to the viewer
/// (docs/lighting.md, Normals).
template <class P>
struct ShadingPoint {
    using Real = typename P::Real;

    Surface<Real> surface;
    Material<Real> material;
    u32 light;
    Vec3<Real> view;
    bool inside;
    Vec3<Real> geometric_normal;
    Vec3<Real> normal;

    HASTE_HD ShadingPoint(const SceneView<Real>& scene, const Ray<Real>& ray,
                          const Surface<Real>& s)
        : surface(s),
          material(scene.materials[scene.shapes[s.shape].material]),
          light(scene.shapes[s.shape].light),
          view(-ray.direction) {
        inside = dot(s.geometric_normal, view) < Real(0);
        geometric_normal = inside ? -s.geometric_normal : s.geometric_normal;
        normal = dot(s.shading_normal, geometric_normal) < Real(0) ? -s.shading_normal
                                                                   : s.shading_normal;
    }

    HASTE_HD Vec3<Real> start(const Vec3<Real>& direction) const {
        return P::Offset::apply(surface.point, geometric_normal, surface.scale, direction);
    }
};

}  // namespace haste
