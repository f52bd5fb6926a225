#pragma once

#include "cuda/kernels/render_params.h"

namespace haste {

/// A packet: rays that were waiting, then camera rays that are made where they are traced.
struct PacketParams {
    RenderParams render;
    const Ray<float>* rays;
    u32 ray_count;
    u32 camera_ray_count;
    u64 first_camera_ray;
    Ray<float>* children;  ///< room for all that the packet can spawn
    u32* child_count;      ///< where they are counted, from what it holds on
};

}  // namespace haste
