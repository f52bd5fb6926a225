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
    u32 packets;       ///< that were not empty
    u32 done;          ///< 1: no ray waits and none is to be made

    alignas(128) u32 children;     ///< of the packet
    alignas(128) u32 shadows;      ///< shadow rays of the packet
    alignas(128) u32 next_ray;     ///< the first of the packet that no warp has taken
    alignas(128) u32 next_shadow;  ///< the same of its shadow rays
};

/// One queue of rays, last in, first out, and the packet that is being worked on. Each kernel does
/// one step of a packet.
///
/// The queue is a ring. A packet is traced where it waited, with camera rays behind it, and its
/// children follow; where older rays wait below, the gap that it leaves is closed.
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
