#pragma once

#include "core/base/bvh2.h"
#include "core/math/vec3.h"

namespace haste {

/// What the slab tests of a ray share: its inverse direction, and how far in t a slab is moved
/// outwards so that no box that holds a hit is missed. Ize, Robust BVH Ray Traversal, JCGT 2(2),
/// 2013, allows for the rounding of the slab test; the primitive's test rounds too, and a hit that
/// it reports may lie beside the box of its primitive (Woop, Benthin and Wald, JCGT 2(1), 2013,
/// section 3.3).
///
/// Let R_a be the distance of the scene's farther face from the origin along axis a, k the main
/// axis of the direction d and T = max R / |d_k|, which no t of a hit exceeds. The tests of
/// triangles and spheres find points that are off by at most 25 u (R_a + |d_a| T) along a, where u
/// is the unit roundoff; the slab test's own operations add 8 u of the same. In t that is
/// 40 u (R_a / |d_a| + T), with some room. It covers ties and t_max as well: the t of a hit is
/// never below the padded entry.
///
/// A component of d that is next to nothing is taken for `least_slope` |d_k|, which moves the ray
/// by at most the difference times T: no infinity and no NaN comes up.
template <class Real>
struct PaddedRay {
    Vec3<Real> origin;
    Vec3<Real> inverse;
    Vec3<Real> pad;  ///< in t, not negative
    Real farthest;   ///< T

    HASTE_HD PaddedRay(const Vec3<Real>& ray_origin, const Vec3<Real>& direction, const Box& bounds)
        : origin(ray_origin) {
        const Vec3<Real> reach{axis_reach(bounds.lower[0], bounds.upper[0], origin.x),
                               axis_reach(bounds.lower[1], bounds.upper[1], origin.y),
                               axis_reach(bounds.lower[2], bounds.upper[2], origin.z)};
        const Real main = max_norm(direction);
        farthest = max_component(reach) / main;
        const Real least = main * Numeric<Real>::least_slope;
        set_axis(direction.x, least, reach.x, farthest, inverse.x, pad.x);
        set_axis(direction.y, least, reach.y, farthest, inverse.y, pad.y);
        set_axis(direction.z, least, reach.z, farthest, inverse.z, pad.z);
    }

private:
    HASTE_HD static Real axis_reach(float lower, float upper, Real origin) {
        return maximum(absolute(Real(lower) - origin), absolute(Real(upper) - origin));
    }

    HASTE_HD static void set_axis(Real direction, Real least, Real reach, Real farthest,
                                  Real& inverse, Real& pad) {
        const Real size = absolute(direction);
        const Real positive = Real(1) / maximum(size, least);
        const Real moved = maximum(Real(1) - size * positive, Real(0));
        inverse = direction < Real(0) ? -positive : positive;
        pad = fma(gamma_bound<Real>(40), fma(reach, positive, farthest), moved * farthest);
    }
};

/// Ray against box by slabs, padded so that no box that holds a hit is missed.
template <class Real>
struct PaddedSlabTest {
    PaddedRay<Real> ray;

    HASTE_HD PaddedSlabTest(const Vec3<Real>& origin, const Vec3<Real>& direction,
                            const Box& bounds)
        : ray(origin, direction, bounds) {}

    /// Distance at which the ray enters the box, t_min if it starts inside, or infinity where it
    /// misses (t_min, t_max].
    HASTE_HD Real enter(const Box& box, Real t_min, Real t_max) const {
        Real near = t_min;
        Real far = t_max;
        clip(box.lower[0], box.upper[0], ray.origin.x, ray.inverse.x, ray.pad.x, near, far);
        clip(box.lower[1], box.upper[1], ray.origin.y, ray.inverse.y, ray.pad.y, near, far);
        clip(box.lower[2], box.upper[2], ray.origin.z, ray.inverse.z, ray.pad.z, near, far);
        return near <= far ? near : Numeric<Real>::infinity;
    }

private:
    HASTE_HD static void clip(float lower, float upper, Real origin, Real inverse, Real pad,
                              Real& near, Real& far) {
        const bool backwards = inverse < Real(0);
        const Real entry = fma(Real(backwards ? upper : lower) - origin, inverse, -pad);
        const Real exit = fma(Real(backwards ? lower : upper) - origin, inverse, pad);
        near = number_maximum(entry, near);
        far = number_minimum(exit, far);
    }
};

}  // namespace haste
