#pragma once

#include "core/base/hit.h"
#include "core/engine/admission.h"
#include "cuda/kernels/render_params.h"

namespace haste {

/// The queue's counters, which never leave the device while it works.
struct WavefrontState {
    u64 next_camera_ray;
    u32 waiting;       ///< rays in the queue; children are appended here
    u32 packet_start;  ///< place in the queue from which the packet's pending rays were taken
    u32 pending;       ///< of the packet's rays, those taken from the queue
    u32 packet;        ///< rays of the packet
    u32 shadows;       ///< shadow rays of the packet
    u32 peak;          ///< most rays that waited
    u32 packets;       ///< that were not empty
    u32 done;          ///< 1: no ray waits and none is to be made
};

/// One queue of rays, last in, first out, and the packet that is being worked on. Each kernel does
/// one step of a packet.
struct WavefrontParams {
    RenderParams render;
    Admission admission;
    u64 camera_rays;
    Ray<float>* queue;
    Ray<float>* packet;
    Hit<float>* hits;
    ShadowRay<float>* shadows;
    WavefrontState* state;
};

}  // namespace haste
