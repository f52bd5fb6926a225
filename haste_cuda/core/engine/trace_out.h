#pragma once

#include "core/base/intersector.h"
#include "core/engine/ray_counts.h"
#include "core/film/film_view.h"

namespace haste {

/// What an engine that traces and shades in one go hands to a model, which sends its output here:
/// light is added up, visibility is settled at once, children go to `children`, which has a
/// function `push`.
template <bool Count, class Real, class I, class Sum, class Children>
    requires Intersector<I, Real>
struct TraceOut {
    const I& intersector;
    const FixedPoint& format;
    Sum& sum;
    RayCounts& counts;
    Children children;

    /// Finds the ray's closest hit and has it shaded.
    template <class Model>
    HASTE_HD void trace(const Model& model, const Ray<Real>& ray) {
        if constexpr (Count) counts.count(ray);
        const Hit<Real> hit = intersector.closest(ray);
        if (hit.found()) {
            model.shade(ray, hit, *this);
        } else {
            model.miss(ray, *this);
        }
    }

    HASTE_HD void radiance(const Ray<Real>&, const Vec3<Real>& value, u32 rounding) {
        sum.add(format, value, rounding);
    }

    HASTE_HD void shadow(const ShadowRay<Real>& ray) {
        if constexpr (Count) ++counts.shadow;
        if (!intersector.occluded(ray)) sum.add(format, ray.value, ray.rounding);
    }

    HASTE_HD void child(const Ray<Real>& ray) { children.push(ray); }
};

}  // namespace haste
