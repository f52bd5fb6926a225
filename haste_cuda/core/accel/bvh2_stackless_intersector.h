#pragma once

#include "core/accel/ray_questions.h"
#include "core/accel/tally.h"
#include "core/base/scene_view.h"

namespace haste {

/// Traversal of the binary BVH without a stack, by parent pointers: the first approach of the
/// paper's section 5.2, which its authors gave up. Where to head next follows from the node and
/// from where the ray came: Hapala, Davidovič, Wald, Havran and Slusallek, Efficient Stack-less BVH
/// Traversal for Ray Tracing, SCCG 2011.
///
/// Whoever comes back up from a child must know whether the other one was visited before it, so the
/// order must not depend on what was found between: entries are compared as they were for the whole
/// of the ray, and only then, against the hits found since, is the farther child skipped.
template <class P, class F, class T = NoTally>
class Bvh2StacklessIntersector : public RayQuestions<Bvh2StacklessIntersector<P, F, T>, P> {
public:
    using Real = typename P::Real;

    HASTE_HD explicit Bvh2StacklessIntersector(const SceneView<Real>& scene, T* tally = nullptr)
        : scene_(scene), tally_(tally) {}

    template <class Start, class Visit>
    HASTE_HD bool traverse(const Vec3<Real>& origin, const Vec3<Real>& direction, Start t_min,
                           Real t_max, Visit&& visit) const {
        const typename P::BoxTest box_test(origin, direction, scene_.bounds);
        const TriangleTestOf<P, F> triangle_test(origin, direction);
        const Real whole = t_max;
        u32 node_index = 0;
        u32 from = from_above;  ///< else the side of the child that was left
        for (;;) {
            T::node(tally_);
            const Bvh2Node node = scene_.nodes[node_index];
            const Real enter0 = box_test.enter(node.box[0], t_min, whole);
            const Real enter1 = box_test.enter(node.box[1], t_min, whole);
            const u32 near = enter1 < enter0 ? 1 : 0;
            const u32 side = from == from_above ? near : 1 - near;
            const Real enter = side == 0 ? enter0 : enter1;
            const u32 child = side == 0 ? node.child[0] : node.child[1];
            const u32 count = side == 0 ? node.count[0] : node.count[1];
            const bool down = from != 1 - near && enter < Numeric<Real>::infinity && enter <= t_max;
            if (down && count == 0) {
                node_index = child;
                from = from_above;
                continue;
            }
            if (down) {
                for (u32 i = child; i < child + count; ++i) {
                    T::primitive(tally_);
                    if (visit_primitive<P, F>(scene_.records[i], triangle_test, origin, direction,
                                              t_min, t_max, visit)) {
                        return true;
                    }
                }
                from = side;
                continue;
            }
            if (node_index == 0) return false;
            const u32 parent = scene_.parents[node_index];
            node_index = parent >> 1;
            from = parent & 1;
        }
    }

private:
    static constexpr u32 from_above = 2;

    const SceneView<Real>& scene_;
    T* tally_;
};

}  // namespace haste
