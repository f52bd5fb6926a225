#pragma once

#include "core/base/hit.h"
#include "core/base/ray.h"
#include "core/base/ray_query.h"

namespace haste {

template <class A, class B>
inline constexpr bool is_same = false;
template <class A>
inline constexpr bool is_same<A, A> = true;
template <class A, class B>
concept Same = is_same<A, B>;

/// Answers where a ray hits. Nobody who asks knows whether it is our BVH on the GPU, our BVH on the
/// CPU, or Embree.
template <class I, class Real>
concept Intersector =
    requires(const I& intersector, const Ray<Real>& ray, const ShadowRay<Real>& shadow) {
        /// Least (t, primitive) with t > 0.
        { intersector.closest(ray) } -> Same<Hit<Real>>;
        /// Whether anything but `shadow.owner` lies on the open segment (0, t_max).
        { intersector.occluded(shadow) } -> Same<bool>;
    };

/// The same of rays without state, which only a replay traces.
template <class I, class Real>
concept QueryIntersector = requires(const I& intersector, const RayQuery<Real>& query) {
    /// Least (t, primitive) within (t_min, t_max].
    { intersector.closest(query) } -> Same<Hit<Real>>;
    /// Whether there is one.
    { intersector.any_hit(query) } -> Same<bool>;
};

}  // namespace haste
