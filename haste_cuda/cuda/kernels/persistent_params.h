#pragma once

#include "cuda/kernels/render_params.h"

namespace haste {

/// Resident warps fetch runs of samples of one pixel; each has a queue of its own for the rays that
/// its samples spawn.
struct PersistentParams {
    RenderParams render;
    u32 run_samples;     ///< samples of a pixel that a lane takes at a time
    u64 runs;            ///< in the whole pass
    u64* next_run;       ///< one, from 0 on
    Ray<float>* queues;  ///< of all warps; none where a ray has one child at most
    u64 queue_capacity;  ///< rays of one warp's queue
};

}  // namespace haste
