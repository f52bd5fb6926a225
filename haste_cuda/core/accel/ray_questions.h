#pragma once

#include "core/base/features.h"
#include "core/base/hit.h"
#include "core/base/primitive.h"
#include "core/base/primitive_hit.h"
#include "core/base/ray.h"
#include "core/base/ray_query.h"

namespace haste {

/// The t_min of rays that start at their origin, as those of images do: known to the compiler.
template <class Real>
struct AtOrigin {
    HASTE_HD constexpr operator Real() const { return Real(0); }
};

/// What is asked of a ray, answered by a traversal `I` of precision `P`, which has
///
///     traverse(origin, direction, t_min, t_max, visit)
///
/// that calls visit(primitive, shape, hit, t_max) for the primitives hit within (t_min, t_max],
/// which visit may shorten, until visit returns true. All traversals test the same primitives in
/// the same way and skip none that is hit, so they all give the same answers, bit for bit.
template <class I, class P>
class RayQuestions {
public:
    using Real = typename P::Real;

    HASTE_HD Hit<Real> closest(const Ray<Real>& ray) const {
        return closest(ray.origin, ray.direction, AtOrigin<Real>(), Numeric<Real>::infinity);
    }

    HASTE_HD Hit<Real> closest(const RayQuery<Real>& query) const {
        return closest(query.origin, query.direction, query.t_min, query.t_max);
    }

    HASTE_HD bool occluded(const ShadowRay<Real>& ray) const {
        return traversal().traverse(ray.origin, ray.direction, AtOrigin<Real>(), ray.t_max,
                                    [&](u32, u32 shape, const PrimitiveHit<Real>& hit, Real&) {
                                        return hit.t < ray.t_max && shape != ray.owner;
                                    });
    }

    HASTE_HD bool any_hit(const RayQuery<Real>& query) const {
        return traversal().traverse(
            query.origin, query.direction, query.t_min, query.t_max,
            [](u32, u32, const PrimitiveHit<Real>&, Real&) { return true; });
    }

private:
    HASTE_HD const I& traversal() const { return static_cast<const I&>(*this); }

    template <class Start>
    HASTE_HD Hit<Real> closest(const Vec3<Real>& origin, const Vec3<Real>& direction, Start t_min,
                               Real farthest) const {
        Hit<Real> best;
        traversal().traverse(origin, direction, t_min, farthest,
                             [&](u32 primitive, u32, const PrimitiveHit<Real>& hit, Real& t_max) {
                                 if (best.loses_to(hit.t, primitive)) {
                                     best = {hit.t, hit.b1, hit.b2, primitive};
                                     t_max = hit.t;
                                 }
                                 return false;
                             });
        return best;
    }
};

/// In the place of what a ray's tests of triangles share, where there are no triangles.
template <class Real>
struct NoTriangleTest {
    HASTE_HD NoTriangleTest(const Vec3<Real>&, const Vec3<Real>&) {}
};

template <class P, bool Triangles>
struct TriangleTestChoice {
    using Type = typename P::TriangleTest;
};

template <class P>
struct TriangleTestChoice<P, false> {
    using Type = NoTriangleTest<typename P::Real>;
};

/// What the tests of a ray against triangles share, made once a ray.
template <class P, class F>
using TriangleTestOf = typename TriangleTestChoice<P, F::triangles>::Type;

/// Tests the primitive of a record; `F` says which kinds there are.
template <class P, class F>
HASTE_HD PrimitiveHit<typename P::Real> test_primitive(
    const PrimitiveRecord<typename P::Real>& record, const TriangleTestOf<P, F>& triangle_test,
    const Vec3<typename P::Real>& origin, const Vec3<typename P::Real>& direction,
    typename P::Real t_min) {
    if constexpr (F::triangles && F::spheres) {
        return record.is_sphere ? intersect_sphere(origin, direction, record.v0, record.v1.x, t_min)
                                : triangle_test.hit(record.v0, record.v1, record.v2);
    } else if constexpr (F::spheres) {
        return intersect_sphere(origin, direction, record.v0, record.v1.x, t_min);
    } else {
        return triangle_test.hit(record.v0, record.v1, record.v2);
    }
}

/// Tests `record` and calls visit(primitive, shape, hit, t_max) if it is hit within (t_min, t_max];
/// whether visit returned true. The record is a copy, so that the GPU loads it 16 bytes at a time.
template <class P, class F, class Visit>
HASTE_HD bool visit_primitive(const PrimitiveRecord<typename P::Real> record,
                              const TriangleTestOf<P, F>& triangle_test,
                              const Vec3<typename P::Real>& origin,
                              const Vec3<typename P::Real>& direction, typename P::Real t_min,
                              typename P::Real& t_max, Visit&& visit) {
    const PrimitiveHit<typename P::Real> hit =
        test_primitive<P, F>(record, triangle_test, origin, direction, t_min);
    return hit.found && hit.t > t_min && hit.t <= t_max &&
           visit(record.primitive, record.shape, hit, t_max);
}

}  // namespace haste
