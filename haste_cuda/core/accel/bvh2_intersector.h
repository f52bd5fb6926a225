#pragma once

#include "core/base/features.h"
#include "core/base/hit.h"
#include "core/base/ray.h"
#include "core/base/ray_query.h"
#include "core/base/scene_view.h"
#include "core/geometry/sphere.h"

namespace haste {

/// Traversal of the binary BVH with a stack, near child first: the iterative plan of the paper's
/// section 5.2. Precision `P` gives the tests, features `F` the kinds of primitive.
template <class P, class F>
class Bvh2Intersector {
public:
    using Real = typename P::Real;

    HASTE_HD explicit Bvh2Intersector(const SceneView<Real>& scene) : scene_(scene) {}

    HASTE_HD Hit<Real> closest(const Ray<Real>& ray) const {
        return closest(ray.origin, ray.direction, AtOrigin(), Numeric<Real>::infinity);
    }

    HASTE_HD Hit<Real> closest(const RayQuery<Real>& query) const {
        return closest(query.origin, query.direction, query.t_min, query.t_max);
    }

    HASTE_HD bool occluded(const ShadowRay<Real>& ray) const {
        return traverse(ray.origin, ray.direction, AtOrigin(), ray.t_max,
                        [&](const PrimitiveRecord<Real>& record, const PrimitiveHit<Real>& hit,
                            Real&) { return hit.t < ray.t_max && record.shape != ray.owner; });
    }

    HASTE_HD bool any_hit(const RayQuery<Real>& query) const {
        return traverse(
            query.origin, query.direction, query.t_min, query.t_max,
            [](const PrimitiveRecord<Real>&, const PrimitiveHit<Real>&, Real&) { return true; });
    }

private:
    /// The t_min of rays that start at their origin, as those of images do: known to the compiler.
    struct AtOrigin {
        HASTE_HD constexpr operator Real() const { return Real(0); }
    };

    template <class Start>
    HASTE_HD Hit<Real> closest(const Vec3<Real>& origin, const Vec3<Real>& direction, Start t_min,
                               Real farthest) const {
        Hit<Real> best;
        traverse(
            origin, direction, t_min, farthest,
            [&](const PrimitiveRecord<Real>& record, const PrimitiveHit<Real>& hit, Real& t_max) {
                if (best.loses_to(hit.t, record.primitive)) {
                    best = {hit.t, hit.b1, hit.b2, record.primitive};
                    t_max = hit.t;
                }
                return false;
            });
        return best;
    }

    /// A child that waits while the nearer one is walked.
    struct Waiting {
        u32 child;
        Real enter;
    };

    /// What is still to be walked, nearest last.
    struct Stack {
        Waiting waiting[max_bvh_depth];
        u32 depth = 0;

        HASTE_HD void push(u32 child, Real enter) { waiting[depth++] = {child, enter}; }

        /// The next child that the ray enters before t_max, or `nothing`.
        HASTE_HD u32 pop(Real t_max) {
            while (depth > 0) {
                const Waiting& top = waiting[--depth];
                if (top.enter <= t_max) return top.child;
            }
            return nothing;
        }

        static constexpr u32 nothing = 0xffffffffu;
    };

    /// Calls `visit(record, hit, t_max)` for the primitives hit within (t_min, t_max], which visit
    /// may shorten, until visit returns true.
    ///
    /// Two loops, so that the threads of a warp go down together and then test primitives together:
    /// Aila and Laine, Understanding the Efficiency of Ray Traversal on GPUs, HPG 2009,
    /// `while-while`.
    template <class Start, class Visit>
    HASTE_HD bool traverse(const Vec3<Real>& origin, const Vec3<Real>& direction, Start t_min,
                           Real t_max, Visit&& visit) const {
        const typename P::BoxTest box_test(origin, direction);
        const typename P::TriangleTest triangle_test(origin, direction);
        Stack stack;
        u32 next = 0;
        for (;;) {
            while (next < first_leaf_reference) {
                const Bvh2Node node = scene_.nodes[next];
                const Real enter0 = box_test.enter(node.box[0], t_min, t_max);
                const Real enter1 = box_test.enter(node.box[1], t_min, t_max);
                const u32 child0 = child_reference(node, 0);
                const u32 child1 = child_reference(node, 1);
                const bool swap = enter1 < enter0;
                const Real farther = swap ? enter0 : enter1;
                next = swap ? child1 : child0;
                if (farther < Numeric<Real>::infinity) {
                    stack.push(swap ? child0 : child1, farther);
                } else if (!((swap ? enter1 : enter0) < Numeric<Real>::infinity)) {
                    next = stack.pop(t_max);
                }
            }
            if (next == Stack::nothing) return false;
            const u32 first = next % first_leaf_reference;
            const u32 end = first + next / first_leaf_reference;
            for (u32 i = first; i < end; ++i) {
                const PrimitiveRecord<Real> record = scene_.records[i];
                const PrimitiveHit<Real> hit =
                    test(record, triangle_test, origin, direction, t_min);
                if (hit.found && hit.t > Real(t_min) && hit.t <= t_max &&
                    visit(record, hit, t_max)) {
                    return true;
                }
            }
            next = stack.pop(t_max);
        }
    }

    HASTE_HD static PrimitiveHit<Real> test(const PrimitiveRecord<Real>& record,
                                            const typename P::TriangleTest& triangle_test,
                                            const Vec3<Real>& origin, const Vec3<Real>& direction,
                                            Real t_min) {
        if constexpr (F::triangles && F::spheres) {
            return record.is_sphere
                       ? intersect_sphere(origin, direction, record.v0, record.v1.x, t_min)
                       : triangle_test.hit(record.v0, record.v1, record.v2);
        } else if constexpr (F::spheres) {
            return intersect_sphere(origin, direction, record.v0, record.v1.x, t_min);
        } else {
            return triangle_test.hit(record.v0, record.v1, record.v2);
        }
    }

    const SceneView<Real>& scene_;
};

}  // namespace haste
