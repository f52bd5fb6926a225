#pragma once

#include "cuda/kernels/render_params.h"

namespace haste {

/// Resident threads fetch runs of samples of one pixel.
struct PersistentParams {
    RenderParams render;
    u32 run_samples;  ///< samples of a pixel that a lane takes at a time
    u64 runs;         ///< in the whole pass
    u64* next_run;    ///< one, from 0 on
};

}  // namespace haste
