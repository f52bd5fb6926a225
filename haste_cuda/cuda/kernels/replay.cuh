#pragma once

#include "core/accel/bvh2_intersector.h"
#include "core/engine/replay.h"
#include "core/precision.h"
#include "cuda/kernels/replay_params.h"

namespace haste {

/// One thread a ray, in the order in which the rays were given.
template <QueryKind Kind, class F, class P>
__device__ void replay(const ReplayParams& parameters) {
    const u64 ray = u64(blockIdx.x) * blockDim.x + threadIdx.x;
    if (ray >= parameters.count) return;
    const Bvh2Intersector<P, F> intersector(parameters.scene);
    parameters.hits[ray] = answer<Kind>(intersector, parameters.queries[ray]);
}

}  // namespace haste
