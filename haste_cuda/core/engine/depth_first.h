#pragma once

#include "core/base/intersector.h"
#include "core/engine/ray_counts.h"
#include "core/film/film_view.h"
#include "core/sampling/camera_ray.h"

namespace haste {

/// Most rays that a depth-first walk of one sample can have pending: every layer leaves all
/// children but one behind, and the ambient rays of one hit lie on top.
HASTE_HD constexpr u32 depth_first_capacity(u32 layers, u32 children, u32 ambient_samples) {
    return (children > 1 ? layers * (children - 1) : 0) + 1 + ambient_samples;
}

/// Receives what a model sends out while one ray of a depth-first walk is shaded: visibility is
/// settled at once, children wait on the private stack.
template <class Real, class I, class Sum, bool Count>
struct DepthFirstOut {
    const I& intersector;
    const FixedPoint& format;
    Sum& sum;
    RayCounts& counts;
    Ray<Real>* stack;
    u32 depth = 0;

    HASTE_HD void radiance(const Ray<Real>&, const Vec3<Real>& value, u32 rounding) {
        sum.add(format, value, rounding);
    }

    HASTE_HD void shadow(const ShadowRay<Real>& ray) {
        if constexpr (Count) ++counts.shadow;
        if (!intersector.occluded(ray)) sum.add(format, ray.value, ray.rounding);
    }

    HASTE_HD void child(const Ray<Real>& ray) { stack[depth++] = ray; }
};

/// Traces and shades one ray for any engine.
template <class Model, class I, class Real, class Out>
HASTE_HD void trace_and_shade(const Model& model, const I& intersector, const Ray<Real>& ray,
                              Out& out) {
    const Hit<Real> hit = intersector.closest(ray);
    if (hit.found()) {
        model.shade(ray, hit, out);
    } else {
        model.miss(ray, out);
    }
}

/// All rays of one sample, children before siblings, with a private stack that has room for
/// `depth_first_capacity` rays.
template <bool Count, class Model, class I, class Real, class Sum>
    requires Intersector<I, Real>
HASTE_HD void trace_sample(const Model& model, const I& intersector, const FixedPoint& format,
                           const Ray<Real>& camera, Ray<Real>* stack, Sum& sum, RayCounts& counts) {
    DepthFirstOut<Real, I, Sum, Count> out{intersector, format, sum, counts, stack};
    out.child(camera);
    while (out.depth > 0) {
        const Ray<Real> ray = stack[--out.depth];
        if constexpr (Count) counts.count(ray);
        trace_and_shade(model, intersector, ray, out);
    }
}

}  // namespace haste
