#pragma once

#include "core/base/bvh2.h"
#include "core/base/bvh8.h"
#include "core/base/camera.h"
#include "core/base/light.h"
#include "core/base/material.h"
#include "core/base/primitive.h"
#include "core/base/shape.h"

namespace haste {

/// A scene as the tracer sees it: plain arrays, owned elsewhere, in the memory of the side that
/// reads.
template <class Real>
struct SceneView {
    Box bounds;  ///< of all primitives
    const Bvh2Node* nodes;
    const u32* parents;  ///< of each node: its parent's index, doubled, plus the side it is on
    const PrimitiveRecord<Real>* records;  ///< in leaf order; spatial splits may repeat a primitive
    const Bvh8Node* wide_nodes;
    const PrimitiveRecord<Real>* wide_records;  ///< in the leaf order of `wide_nodes`

    const Vec3<Real>* vertices;
    const Vec3<Real>* normals;  ///< per vertex; read only where a shape is smooth
    const u32* triangles;       ///< three vertex indices a triangle
    const u32* triangle_shape;
    const Vec3<Real>* sphere_centre;
    const Real* sphere_radius;
    const u32* sphere_shape;
    u32 triangle_count;
    u32 sphere_count;

    const Shape* shapes;
    const Material<Real>* materials;
    const Light<Real>* lights;
    const Real*
        light_cdf;  ///< cumulated triangle areas of the mesh lights, each ending at its area
    u32 light_count;

    Vec3<Real> environment;  ///< radiance of the constant environment, 0 without one
    Camera<Real> camera;
};

}  // namespace haste
