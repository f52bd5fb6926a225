#pragma once

#include "core/base/hit.h"
#include "core/engine/admission.h"
#include "cuda/kernels/render_params.h"
#include "cuda/kernels/shadow_list.h"

namespace haste {

/// The queue's counters, which never leave the device while it works. Those that many warps add to
/// at once have a cache line each.
struct WavefrontState {
    u64 next_camera_ray;
    u64 peak_bytes;    ///< most that rays, hits and shadow rays took
    u32 first;         ///< place of the oldest ray that waits
    u32 rest;          ///< rays that wait while the packet is worked on
    u32 packet_start;  ///< place of the packet's rays
    u32 pending;       ///< of them, those that were waiting; camera rays follow
    u32 packet;        ///< rays of the packet
    u32 child_start;   ///< place of the packet's children
    u32 gap;           ///< places that the packet leaves between older rays and its children
    u32 packets;       ///< that were not empty
    u32 done;          ///< 1: no ray waits and none is to be made

    alignas(128) u32 children;     ///< of the packet
    alignas(128) u32 shadows;      ///< shadow rays of the packet
    alignas(128) u32 next_ray;     ///< the first of the packet that no warp has taken
    alignas(128) u32 next_shadow;  ///< the same of its shadow rays
};

/// Decides what the next packet is made of, once the one before has been worked on.
///
/// The queue is a ring of `queue_size` places. A packet is traced where it waited, and its children
/// follow behind all that waits; camera rays are made behind it where no other rays are. It is of
/// the oldest rays, for the newest leave a gap below their children; near the queue's limit they
/// are taken nevertheless (see `Admission`), and the gap is closed.
HASTE_HD inline void plan_packet(WavefrontState& state, const Admission& admission, u64 camera_rays,
                                 u32 queue_size) {
    const auto wrapped = [&](u32 place) { return place < queue_size ? place : place - queue_size; };
    if (state.rest == 0) state.first = state.child_start;
    const u32 waiting = state.rest + state.children;
    const PacketPlan plan = admission.next(waiting, camera_rays - state.next_camera_ray);
    state.next_camera_ray += plan.born;
    state.pending = u32(plan.pending);
    state.packet = u32(plan.size());
    state.rest = waiting - state.pending;
    state.packet_start = wrapped(state.first + (plan.lifo ? state.rest : 0));
    state.child_start = wrapped(state.first + waiting + u32(plan.born));
    state.gap = plan.lifo && state.rest > 0 ? state.pending : 0;
    if (!plan.lifo) state.first = wrapped(state.first + state.pending);
    state.children = 0;
    state.shadows = 0;
    state.next_ray = 0;
    state.next_shadow = 0;
    state.done = plan.size() == 0;
    if (!state.done) ++state.packets;
}

/// One queue of rays and the packet that is being worked on. Each kernel does one step of a packet.
struct WavefrontParams {
    RenderParams render;
    Admission admission;
    u64 camera_rays;
    Ray<float>* queue;
    u32 queue_size;
    Hit<float>* hits;
    ShadowList shadows;
    WavefrontState* state;

    /// The ray at a place of the ring, which may be given one turn too far on.
    HASTE_HD Ray<float>& ray(u32 place) const {
        return queue[place < queue_size ? place : place - queue_size];
    }

    /// What a ray of a packet takes beside its place in the queue.
    HASTE_HD static constexpr u64 packet_ray_bytes(u64 most_shadow_rays) {
        return sizeof(Ray<float>) + sizeof(Hit<float>) + most_shadow_rays * ShadowList::ray_bytes;
    }
};

}  // namespace haste
