#pragma once

#include "core/accel/bvh8_intersector.h"
#include "core/engine/replay.h"
#include "core/precision.h"
#include "cuda/kernels/replay_params.h"
#include "cuda/kernels/warp.cuh"

namespace haste {

/// When a warp gives up the rays that it still has to walk side by side and takes new ones: each
/// round costs the lanes that are idle beyond `tolerated`, and `patience` is what may be lost
/// (Ylitie, Karras and Laine 2017, section 4.2: N_d and N_w).
template <QueryKind Kind>
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

/// Rays are read once: they must not drive the hierarchy out of the caches.
__device__ inline RayQuery<float> load_query(const RayQuery<float>* queries, u32 index) {
    const auto* words = reinterpret_cast<const float4*>(queries + index);
    const float4 a = __ldcs(words), b = __ldcs(words + 1);
    return {{a.x, a.y, a.z}, a.w, {b.x, b.y, b.z}, b.w};
}

__device__ inline void store_hit(QueryHit<float>* hits, u32 index, const QueryHit<float>& hit) {
    __stcs(reinterpret_cast<float2*>(hits + index), float2{hit.t, bits_float(hit.primitive)});
}

/// What a lane knows of its ray.
template <QueryKind Kind, class F, class P>
struct ResidentRay {
    Bvh8NodeTest node_test;
    TriangleTestOf<P, F> triangle_test;
    Vec3<float> direction;
    float t_min, t_max;
    QueryHit<float> best;
    u32 index;

    __device__ ResidentRay(const RayQuery<float>& query, const Box& bounds, u32 ray_index)
        : node_test(query.origin, query.direction, bounds),
          triangle_test(query.origin, query.direction),
          direction(query.direction),
          t_min(query.t_min),
          t_max(query.t_max),
          best{Numeric<float>::infinity, no_primitive},
          index(ray_index) {}

    /// Tests a primitive; whether nothing more need be.
    __device__ bool test(const PrimitiveRecord<float>& record) {
        return visit_primitive<P, F>(
            record, triangle_test, node_test.ray.origin, direction, t_min, t_max,
            [this](u32 primitive, u32, const PrimitiveHit<float>& hit, float& farthest) {
                if constexpr (Kind == QueryKind::any_hit) {
                    best.t = 0.0f;
                    return true;
                } else {
                    if (hit.t < best.t || primitive < best.primitive) {
                        best = {hit.t, primitive};
                        farthest = hit.t;
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
template <QueryKind Kind, class F, class P>
__device__ void replay_resident(const ReplayParams& parameters) {
    extern __shared__ Bvh8Group shared_stack[];
    const SceneView<float>& scene = parameters.scene;
    Bvh8Group local_stack[ResidentStack::local_entries];
    ResidentStack stack(shared_stack, local_stack);
    ResidentRay<Kind, F, P> ray({{0, 0, 0}, 0, {0, 0, 1}, 0}, scene.bounds, 0);
    // A ray has nodes in `group` and on the stack, and what to test before it goes on; it is done
    // when there is neither.
    Bvh8Group group{0, 0};
    PrimitiveGroup primitives{0, 0, 0};
    bool active = false;
    bool more = true;
    for (;;) {
        if (more) {
            const u32 idle = __ballot_sync(whole_warp, !active);
            u32 first = 0;
            if (lane_index() == 0) first = atomicAdd(parameters.next, count_bits(idle));
            first = __shfl_sync(whole_warp, first, 0);
            const u32 mine = first + count_bits(idle & lanes_below());
            if (!active && mine < parameters.count) {
                ray = ResidentRay<Kind, F, P>(load_query(parameters.queries, mine), scene.bounds,
                                              mine);
                group = Bvh8Group::root();
                active = true;
            }
            more = first + count_bits(idle) < parameters.count;
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
                    ray.test(load_record(scene.wide_records, primitives.pop()))) {
                    primitives.waiting = 0;
                    group.bits = 0;
                    stack.clear();
                }
                wanting = __ballot_sync(whole_warp, primitives.waiting != 0);
                going |= working & ~wanting;
            }
            if (active && primitives.waiting == 0 && group.empty()) {
                store_hit(parameters.hits, ray.index, ray.best);
                active = false;
            }
            working = __ballot_sync(whole_warp, active);
            const int idle = int(warp_size - count_bits(working));
            lost += max(idle - FetchPolicy<Kind>::tolerated, 0);
        } while (working != 0 && (!more || lost < FetchPolicy<Kind>::patience));
    }
}

}  // namespace haste
