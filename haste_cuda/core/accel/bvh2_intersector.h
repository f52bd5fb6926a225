#pragma once

#include "core/accel/ray_questions.h"
#include "core/accel/tally.h"
#include "core/base/scene_view.h"

namespace haste {

/// Traversal of the binary BVH with a stack, near child first: the iterative plan of the paper's
/// section 5.2. Precision `P` gives the tests, features `F` the kinds of primitive, `T` counts.
template <class P, class F, class T = NoTally>
class Bvh2Intersector : public RayQuestions<Bvh2Intersector<P, F, T>, P> {
public:
    using Real = typename P::Real;

    HASTE_HD explicit Bvh2Intersector(const SceneView<Real>& scene, T* tally = nullptr)
        : scene_(scene), tally_(tally) {}

    /// Two loops, so that the threads of a warp go down together and then test primitives together:
    /// Aila and Laine, Understanding the Efficiency of Ray Traversal on GPUs, HPG 2009,
    /// `while-while`.
    template <class Start, class Visit>
    HASTE_HD bool traverse(const Vec3<Real>& origin, const Vec3<Real>& direction, Start t_min,
                           Real t_max, Visit&& visit) const {
        const typename P::BoxTest box_test(origin, direction, scene_.bounds);
        const TriangleTestOf<P, F> triangle_test(origin, direction);
        Stack stack;
        u32 next = 0;
        for (;;) {
            while (next < first_leaf_reference) {
                T::node(tally_);
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
                T::primitive(tally_);
                if (visit_primitive<P, F>(scene_.records[i], triangle_test, origin, direction,
                                          t_min, t_max, visit)) {
                    return true;
                }
            }
            next = stack.pop(t_max);
        }
    }

private:
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

    const SceneView<Real>& scene_;
    T* tally_;
};

}  // namespace haste
