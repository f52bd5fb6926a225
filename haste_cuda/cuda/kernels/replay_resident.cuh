#pragma once

#include "core/engine/replay.h"
#include "core/precision.h"
#include "cuda/kernels/replay_params.h"
#include "cuda/kernels/resident.cuh"

namespace haste {

/// The rays of a replay.
template <QueryKind Kind>
struct ReplayTask {
    static constexpr bool any_hit = Kind == QueryKind::any_hit;
    using Start = float;
    const ReplayParams& parameters;

    __device__ u32 count() const { return parameters.count; }
    __device__ u32* next() const { return parameters.next; }

    __device__ static Start t_min(const RayQuery<float>& query) { return query.t_min; }

    /// Rays are read once: they must not drive the hierarchy out of the caches.
    __device__ RayQuery<float> load(u32 index) const {
        const auto* words = reinterpret_cast<const float4*>(parameters.queries + index);
        const float4 a = __ldcs(words), b = __ldcs(words + 1);
        return {{a.x, a.y, a.z}, a.w, {b.x, b.y, b.z}, b.w};
    }

    __device__ bool blocks(u32, u32, float, float) const { return true; }

    __device__ void note(u32 index, const Hit<float>& hit) const {
        if constexpr (any_hit) {
            store(index, {0.0f, no_primitive});
        } else {
            store(index, {hit.t, hit.primitive});
        }
    }
    __device__ u32 noted(u32 index) const { return parameters.hits[index].primitive; }
    __device__ void miss(u32 index) const {
        store(index, {Numeric<float>::infinity, no_primitive});
    }

private:
    __device__ void store(u32 index, const QueryHit<float>& hit) const {
        const float2 words{hit.t, bits_float(hit.primitive)};
        __stcs(reinterpret_cast<float2*>(parameters.hits + index), words);
    }
};

/// A replay by resident warps.
template <QueryKind Kind, class F, class P>
__device__ void replay_resident(const ReplayParams& parameters) {
    trace_resident<ReplayTask<Kind>, F, P>(parameters.scene, {parameters});
}

}  // namespace haste
