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

    /// Calls `visit(record, hit, t_max)` for the primitives hit within (t_min, t_max], which visit
    /// may shorten, until visit returns true.
    template <class Start, class Visit>
    HASTE_HD bool traverse(const Vec3<Real>& origin, const Vec3<Real>& direction, Start t_min,
                           Real t_max, Visit&& visit) const {
        const typename P::BoxTest box_test(origin, direction);
        const typename P::TriangleTest triangle_test(origin, direction);
        u32 stack[max_bvh_depth];
        u32 depth = 0;
        u32 node_index = 0;
        for (;;) {
            const Bvh2Node& node = scene_.nodes[node_index];
            Real enter[2];
            bool descend[2];
            for (int i = 0; i < 2; ++i) {
                enter[i] = box_test.enter(node.box[i], t_min, t_max);
                descend[i] = enter[i] < Numeric<Real>::infinity;
            }
            const int first = enter[1] < enter[0];
            for (int k = 0; k < 2; ++k) {
                const int i = k == 0 ? first : 1 - first;
                if (!descend[i] || node.count[i] == 0) continue;
                descend[i] = false;
                // The first leaf may have shortened the ray to before the second.
                if (enter[i] > t_max) continue;
                for (u32 j = 0; j < node.count[i]; ++j) {
                    const PrimitiveRecord<Real>& record = scene_.records[node.child[i] + j];
                    const PrimitiveHit<Real> hit =
                        test(record, triangle_test, origin, direction, t_min);
                    if (hit.found && hit.t > Real(t_min) && hit.t <= t_max &&
                        visit(record, hit, t_max)) {
                        return true;
                    }
                }
            }
            if (descend[0] && descend[1]) {
                stack[depth++] = node.child[1 - first];
                node_index = node.child[first];
            } else if (descend[0] || descend[1]) {
                node_index = node.child[descend[0] ? 0 : 1];
            } else if (depth > 0) {
                node_index = stack[--depth];
            } else {
                return false;
            }
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
