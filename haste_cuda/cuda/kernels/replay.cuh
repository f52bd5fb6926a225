#pragma once

#include "core/accel/traversal.h"
#include "core/engine/replay.h"
#include "core/precision.h"
#include "cuda/kernels/replay_params.h"

namespace haste {

/// One thread a ray, in the order in which the rays were given. With `Count` it counts what is
/// visited.
template <QueryKind Kind, TraversalKind K, class F, class P, bool Count>
__device__ void replay(const ReplayParams& parameters) {
    const u64 ray = u64(blockIdx.x) * blockDim.x + threadIdx.x;
    if (ray >= parameters.count) return;
    if constexpr (Count) {
        Tally tally;
        const IntersectorOf<K, P, F, Tally> intersector(parameters.scene, &tally);
        parameters.hits[ray] = answer<Kind>(intersector, parameters.queries[ray]);
        atomicAdd(&parameters.visited->nodes, tally.nodes);
        atomicAdd(&parameters.visited->primitives, tally.primitives);
    } else {
        const IntersectorOf<K, P, F> intersector(parameters.scene);
        parameters.hits[ray] = answer<Kind>(intersector, parameters.queries[ray]);
    }
}

}  // namespace haste
