#pragma once

#include "core/accel/traversal.h"
#include "core/engine/depth_first.h"
#include "core/film/float_sum.h"
#include "core/model/haste_model.h"
#include "core/model/path_model.h"
#include "core/precision.h"
#include "cuda/kernels/render_params.h"
#include "cuda/kernels/warp.cuh"

namespace haste {

/// What a kernel is compiled for, in one type.
template <template <class, class> class M, class F, class P, TraversalKind Traversal, u32 Capacity,
          class FilmSumType, bool Layered, bool Count>
struct KernelConfig {
    using Real = typename P::Real;
    using Features = F;
    using Precision = P;
    using Model = M<P, F>;
    using Intersector = IntersectorOf<Traversal, P, F>;
    using Sum = FilmSumType;
    /// Whether a step that only traces is done by warps that stay: `trace_resident`.
    static constexpr bool resident = Traversal == TraversalKind::bvh8;
    static constexpr u32 stack_capacity = Capacity;  ///< rays that a private stack holds
    static constexpr bool layered = Layered;  ///< a film a layer, weighted afterwards (equation 8)
    static constexpr bool count = Count;
};

/// The next place of a counter for each thread that asks, by one atomic add for all lanes of a warp
/// that ask together (Adinetz, CUDA Pro Tip: Optimized Filtering with Warp-Aggregated Atomics,
/// 2014).
template <class T>
__device__ T claim(T* counter) {
    const u32 asking = __activemask();
    const int leader = __ffs(int(asking)) - 1;
    T first = 0;
    if (int(lane_index()) == leader) first = atomicAdd(counter, T(__popc(asking)));
    return __shfl_sync(asking, first, leader) + T(__popc(asking & lanes_below()));
}

/// An atomic add that returns nothing, so that nothing waits for it: `red`. Of a plain atomicAdd
/// beside one whose result is used the compiler makes an `atom`, which is waited for.
__device__ inline void reduce_add(u64* target, u64 value) {
#if defined(__CUDA_ARCH__)
    asm volatile("red.global.add.u64 [%0], %1;" : : "l"(target), "l"(value) : "memory");
#else
    atomicAdd(target, value);  // kernels that g++ compiles for the emulated GPU
#endif
}

/// Adds to the film. Few adds are so large that they check the sum for overflow
/// (`FilmTarget::unchecked_below`).
__device__ inline void add_to_film(const FilmTarget& film, u64 place, u32 pixel, FilmSum sum) {
    for (int c = 0; c < 3; ++c) {
        if (sum.channel[c] == 0) continue;
        auto* target = reinterpret_cast<u64*>(film.sums + 3 * place + c);
        const u64 units = u64(sum.channel[c]);
        if (units < film.unchecked_below) {
            reduce_add(target, units);
        } else if (atomicAdd(target, units) > u64(FilmSum::max_sum) - units) {
            sum.overflow = true;
        }
    }
    if (sum.non_finite) atomicAdd(&film.faults->non_finite, u64(sum.non_finite));
    if (sum.overflow) atomicMin(&film.faults->overflow_pixel, pixel);
}

__device__ inline void add_to_film(const FilmTarget& film, u64 place, u32, const FloatSum& sum) {
    for (int c = 0; c < 3; ++c) {
        if (sum.channel[c] != 0.0f) atomicAdd(film.values + 3 * place + c, sum.channel[c]);
    }
    if (sum.non_finite) atomicAdd(&film.faults->non_finite, u64(sum.non_finite));
}

/// Where the light of a ray goes in the film.
template <class C>
__device__ u64 film_place(const RenderParams& parameters, u32 pixel, u32 layer) {
    if constexpr (!C::layered) return pixel;
    const Camera<float>& camera = parameters.scene.camera;
    return u64(layer) * camera.width * camera.height + pixel;
}

__device__ inline void add_counts(RayCounts* total, const RayCounts& rays) {
    if (rays.camera) atomicAdd(&total->camera, rays.camera);
    if (rays.shadow) atomicAdd(&total->shadow, rays.shadow);
    if (rays.ambient) atomicAdd(&total->ambient, rays.ambient);
    if (rays.bounce) atomicAdd(&total->bounce, rays.bounce);
}

/// What a kernel hands to its model.
template <class C, class Children>
using KernelTraceOut =
    TraceOut<C::count, typename C::Real, typename C::Intersector, typename C::Sum, Children>;

/// A list of rays in device memory, written without gaps.
template <class C>
struct CompactRays {
    Ray<float>* rays;
    u32* count;

    __device__ void push(Ray<float> ray) {
        if constexpr (C::layered) drop_contribution(ray);
        rays[claim(count)] = ray;
    }
};

}  // namespace haste
