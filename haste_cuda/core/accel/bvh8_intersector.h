#pragma once

#include "core/accel/bvh8_node_test.h"
#include "core/accel/ray_questions.h"
#include "core/accel/tally.h"
#include "core/base/scene_view.h"

namespace haste {

/// Children of one node that wait: in the upper byte of `bits`, ordered by `in_order`, those to be
/// visited; in the lower byte all inner children of the node, which tell their places.
struct Bvh8Group {
    u32 first_child;
    u32 bits;

    HASTE_HD static Bvh8Group root() { return {0, 1u << 31}; }

    HASTE_HD bool empty() const { return bits < 1u << 24; }

    /// Takes out the child to be visited first and returns its node.
    HASTE_HD u32 pop(u32 octant) {
        const u32 bit = highest_bit(bits);
        bits &= ~(1u << bit);
        const u32 slot = (bit - 24) ^ octant;
        return first_child + count_bits(bits & 0xffu & ~(0xffffffffu << slot));
    }
};

/// Traversal of the compressed BVH with eight children, one stack entry a node: Ylitie, Karras and
/// Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017,
/// section 3.
template <class P, class F, class T = NoTally>
class Bvh8Intersector : public RayQuestions<Bvh8Intersector<P, F, T>, P> {
public:
    using Real = typename P::Real;

    HASTE_HD explicit Bvh8Intersector(const SceneView<Real>& scene, T* tally = nullptr)
        : scene_(scene), tally_(tally) {}

    template <class Start, class Visit>
    HASTE_HD bool traverse(const Vec3<Real>& origin, const Vec3<Real>& direction, Start t_min,
                           Real t_max, Visit&& visit) const {
        const Bvh8NodeTest node_test(origin, direction, scene_.bounds);
        const TriangleTestOf<P, F> triangle_test(origin, direction);
        Bvh8Group stack[max_bvh8_depth];
        u32 depth = 0;
        Bvh8Group group = Bvh8Group::root();
        for (;;) {
            const u32 index = group.pop(node_test.octant);
            if (!group.empty()) stack[depth++] = group;
            T::node(tally_);
            const Bvh8Node node = scene_.wide_nodes[index];
            const u32 hits = node_test.hits(node, t_min, t_max);
            u32 primitives = hits & node.primitives;
            while (primitives != 0) {
                const u32 bit = lowest_bit(primitives);
                primitives &= primitives - 1;
                const u32 place = count_bits(node.primitives & ~(0xffffffffu << bit));
                T::primitive(tally_);
                if (visit_primitive<P, F>(scene_.wide_records[node.first_primitive + place],
                                          triangle_test, origin, direction, t_min, t_max, visit)) {
                    return true;
                }
            }
            const u32 inner = node.inner();
            group = {node.first_child, node_test.in_order((hits >> 24) & inner) << 24 | inner};
            if (group.empty()) {
                if (depth == 0) return false;
                group = stack[--depth];
            }
        }
    }

private:
    const SceneView<Real>& scene_;
    T* tally_;
};

}  // namespace haste
