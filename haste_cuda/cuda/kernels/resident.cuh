#pragma once

#include "core/accel/bvh8_intersector.h"
#include "cuda/kernels/resident_params.h"
#include "cuda/kernels/warp.cuh"

namespace haste {

/// When a warp gives up the rays that it still has to walk side by side and takes new ones: each
/// round costs the lanes that are idle beyond `tolerated`, and `patience` is what may be lost
/// (Ylitie, Karras and Laine 2017, section 4.2: N_d and N_w).
struct FetchPolicy {
    static constexpr int tolerated = 4;
    static constexpr int patience = 16;
};

/// Lanes that have primitives to test wait for others while fewer than one in so many that are at
/// work have some (section 4.3, where they are put on the stack and the lane goes on).
inline constexpr u32 quorum = 4;

/// Primitives of a node that are still to be tested.
struct PrimitiveGroup {
    u32 first;
    u32 mask;     ///< the node's `primitives`, which tells places
    u32 waiting;  ///< bits of `mask`

    __device__ u32 pop() {
        const u32 bit = lowest_bit(waiting);
        waiting &= waiting - 1;
        return first + count_bits(mask & ~(0xffffffffu << bit));
    }
};

/// The stack of a thread, one entry a level: its lower end, where it mostly is, in shared memory,
/// interleaved among the threads of the block; the rest in local memory.
class ResidentStack {
public:
    static constexpr u32 local_entries = max_bvh8_depth - shared_stack_entries;

    /// `shared` has `shared_stack_entries` entries for each thread of the block.
    __device__ ResidentStack(Bvh8Group* shared, Bvh8Group* local)
        : shared_(u32(__cvta_generic_to_shared(shared + threadIdx.x))), local_(local) {}

    __device__ bool empty() const { return size_ == 0; }
    __device__ void clear() { size_ = 0; }

    __device__ void push(const Bvh8Group& group) {
        if (size_ < shared_stack_entries) {
            asm volatile("st.shared.v2.u32 [%0], {%1, %2};"
                         :
                         : "r"(shared_address()), "r"(group.first_child), "r"(group.bits)
                         : "memory");
        } else {
            local_[size_ - shared_stack_entries] = group;
        }
        ++size_;
    }

    __device__ Bvh8Group pop() {
        --size_;
        if (size_ >= shared_stack_entries) return local_[size_ - shared_stack_entries];
        Bvh8Group group;
        asm volatile("ld.shared.v2.u32 {%0, %1}, [%2];"
                     : "=r"(group.first_child), "=r"(group.bits)
                     : "r"(shared_address())
                     : "memory");
        return group;
    }

private:
    /// An address within shared memory: a generic one would be made anew at every access.
    __device__ u32 shared_address() const {
        return shared_ + size_ * blockDim.x * u32(sizeof(Bvh8Group));
    }

    u32 shared_;
    Bvh8Group* local_;
    u32 size_ = 0;
};

__device__ inline Bvh8Node load_node(const Bvh8Node* nodes, u32 index) {
    const auto* words = reinterpret_cast<const uint4*>(nodes + index);
    const uint4 a = __ldg(words), b = __ldg(words + 1), c = __ldg(words + 2);
    const uint4 d = __ldg(words + 3), e = __ldg(words + 4);
    return {{bits_float(a.x), bits_float(a.y), bits_float(a.z)},
            a.w,
            b.x,
            b.y,
            b.z,
            b.w,
            {{{c.x, c.y}, {c.z, c.w}, {d.x, d.y}}, {{d.z, d.w}, {e.x, e.y}, {e.z, e.w}}}};
}

__device__ inline PrimitiveRecord<float> load_record(const PrimitiveRecord<float>* records,
                                                     u32 index) {
    const auto* words = reinterpret_cast<const float4*>(records + index);
    const float4 a = __ldg(words), b = __ldg(words + 1), c = __ldg(words + 2);
    return {{a.x, a.y, a.z}, {a.w, b.x, b.y}, {b.z, b.w, c.x},
            float_bits(c.y), float_bits(c.z), float_bits(c.w)};
}

/// What a lane knows of its ray.
template <class Task, class F, class P>
struct ResidentRay {
    Bvh8NodeTest node_test;
    TriangleTestOf<P, F> triangle_test;
    Vec3<float> direction;
    typename Task::Start t_min;
    float t_max;  ///< of the best hit, once there is one
    u32 index;

    __device__ ResidentRay(const RayQuery<float>& query, const Box& bounds, u32 ray_index)
        : node_test(query.origin, query.direction, bounds),
          triangle_test(query.origin, query.direction),
          direction(query.direction),
          t_min(Task::t_min(query)),
          t_max(query.t_max),
          index(ray_index) {}

    /// No ray at all.
    __device__ explicit ResidentRay(const Box& bounds)
        : ResidentRay({{0, 0, 0}, 0, {0, 0, 1}, 0}, bounds, nobody) {}

    static constexpr u32 nobody = 0xffffffffu;

    /// Tests a primitive; whether nothing more need be.
    __device__ bool test(const Task& task, const PrimitiveRecord<float>& record) {
        return visit_primitive<P, F>(
            record, triangle_test, node_test.ray.origin, direction, t_min, t_max,
            [&](u32 primitive, u32 shape, const PrimitiveHit<float>& hit, float& farthest) {
                if constexpr (Task::any_hit) {
                    if (!task.blocks(index, shape, hit.t, farthest)) return false;
                    task.note(index, {hit.t, hit.b1, hit.b2, primitive});
                    index = nobody;
                    return true;
                } else {
                    // No t beyond `farthest` comes here.
                    if (hit.t < farthest || primitive < task.noted(index)) {
                        farthest = hit.t;
                        task.note(index, {hit.t, hit.b1, hit.b2, primitive});
                    }
                    return false;
                }
            });
    }
};

/// Resident warps on the compressed BVH with eight children: a lane whose ray is done takes the
/// next one (Aila and Laine, Understanding the Efficiency of Ray Traversal on GPUs, HPG 2009), when
/// enough lanes are idle, and primitives are tested when enough lanes have some (Ylitie, Karras and
/// Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017,
/// section 4). The whole warp goes through every round together.
///
/// A task is a list of rays and what becomes of their hits:
///
///     any_hit                            whether one hit that blocks is all that is asked for
///     Start, t_min(query)                a number, or one that the compiler knows
///     count(), next()                    rays, and the device's counter of those that are taken
///     load(index)                        the RayQuery of a ray
///     blocks(index, shape, t, t_max)     of any hit: whether this one counts
///     miss(index)                        of any hit: a ray is done that nothing blocked
///     note(index, hit)                   a hit that counts, the closest so far; of the closest
///                                        also a Hit that is none, when its ray is begun
///     noted(index)                       the primitive of that hit
///
/// Hits are written as they are found, so that no lane keeps any in registers.
template <class Task, class F, class P>
__device__ void trace_resident(const SceneView<float>& scene, const Task& task) {
    extern __shared__ Bvh8Group shared_stack[];
    Bvh8Group local_stack[ResidentStack::local_entries];
    ResidentStack stack(shared_stack, local_stack);
    using LaneRay = ResidentRay<Task, F, P>;
    LaneRay ray(scene.bounds);
    // A ray has nodes in `group` and on the stack, and what to test before it goes on; it is done
    // when there is neither.
    Bvh8Group group{0, 0};
    PrimitiveGroup primitives{0, 0, 0};
    bool active = false;
    bool more = true;
    for (;;) {
        if constexpr (Task::any_hit) {
            if (!active && ray.index != LaneRay::nobody) {
                task.miss(ray.index);
                ray.index = LaneRay::nobody;
            }
        }
        if (more) {
            const u32 idle = __ballot_sync(whole_warp, !active);
            u32 first = 0;
            if (lane_index() == 0) first = atomicAdd(task.next(), count_bits(idle));
            first = __shfl_sync(whole_warp, first, 0);
            const u32 mine = first + count_bits(idle & lanes_below());
            if (!active && mine < task.count()) {
                ray = LaneRay(task.load(mine), scene.bounds, mine);
                if constexpr (!Task::any_hit) task.note(mine, {});
                group = Bvh8Group::root();
                active = true;
            }
            more = first + count_bits(idle) < task.count();
        }
        u32 working = __ballot_sync(whole_warp, active);
        if (working == 0) break;
        int lost = 0;
        do {
            if (active && primitives.waiting == 0) {
                const u32 index = group.pop(ray.node_test.octant);
                if (!group.empty()) stack.push(group);
                const Bvh8Node node = load_node(scene.wide_nodes, index);
                const u32 hits = ray.node_test.hits(node, ray.t_min, ray.t_max);
                const u32 inner = node.inner();
                primitives = {node.first_primitive, node.primitives, hits & node.primitives};
                group = {node.first_child,
                         ray.node_test.in_order((hits >> 24) & inner) << 24 | inner};
                if (group.empty() && !stack.empty()) group = stack.pop();
            }
            u32 wanting = __ballot_sync(whole_warp, primitives.waiting != 0);
            u32 going = __ballot_sync(whole_warp, primitives.waiting == 0 && !group.empty());
            while (wanting != 0 &&
                   (quorum * count_bits(wanting) >= count_bits(working) || going == 0)) {
                if (primitives.waiting != 0 &&
                    ray.test(task, load_record(scene.wide_records, primitives.pop()))) {
                    primitives.waiting = 0;
                    group.bits = 0;
                    stack.clear();
                }
                wanting = __ballot_sync(whole_warp, primitives.waiting != 0);
                going |= working & ~wanting;
            }
            if (primitives.waiting == 0 && group.empty()) active = false;
            working = __ballot_sync(whole_warp, active);
            const int idle = int(warp_size - count_bits(working));
            lost += max(idle - FetchPolicy::tolerated, 0);
        } while (working != 0 && (!more || lost < FetchPolicy::patience));
    }
}

}  // namespace haste
