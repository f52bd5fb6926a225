#pragma once

#include "core/accel/bvh2_intersector.h"
#include "core/engine/depth_first.h"
#include "core/model/haste_model.h"
#include "core/model/path_model.h"
#include "core/precision.h"
#include "cuda/kernels/depth_first_params.h"

namespace haste {

/// Adds a sample's integers to the film. The sum before the add tells whether it overflowed; the
/// film is refused then, so the wrapped sum is never read.
__device__ inline void add_to_film(const DepthFirstParams& parameters, u32 pixel, FilmSum& sum) {
    for (int c = 0; c < 3; ++c) {
        if (sum.channel[c] == 0) continue;
        auto* target = reinterpret_cast<u64*>(parameters.sums + 3 * u64(pixel) + c);
        const i64 before = i64(atomicAdd(target, u64(sum.channel[c])));
        if (before > FilmSum::max_sum - sum.channel[c]) sum.overflow = true;
    }
    if (sum.non_finite) atomicAdd(&parameters.faults->non_finite, u64(sum.non_finite));
    if (sum.overflow) atomicMin(&parameters.faults->overflow_pixel, pixel);
}

/// One thread a sample, private stack: the mega-kernel.
template <template <class, class> class Model, class F, class P, u32 Capacity, bool Count>
__device__ void depth_first(const DepthFirstParams& parameters) {
    using Real = typename P::Real;
    const u64 item = u64(blockIdx.x) * blockDim.x + threadIdx.x;
    if (item >= parameters.items()) return;
    constexpr u32 tile_pixels = DepthFirstParams::tile_width * DepthFirstParams::tile_height;
    const u32 lane = u32(item % tile_pixels);
    const u64 tile = item / tile_pixels;
    const u32 tiles = parameters.tiles_across() * parameters.tiles_down();
    const u32 index = u32(tile % tiles);
    const u32 sample = parameters.first_sample + u32(tile / tiles);
    const u32 x = index % parameters.tiles_across() * DepthFirstParams::tile_width +
                  lane % DepthFirstParams::tile_width;
    const u32 y = index / parameters.tiles_across() * DepthFirstParams::tile_height +
                  lane / DepthFirstParams::tile_width;
    const Camera<Real>& camera = parameters.scene.camera;
    if (x >= camera.width || y >= camera.height) return;
    const u32 pixel = y * camera.width + x;

    const Model<P, F> model(parameters.scene, parameters.settings);
    const Bvh2Intersector<P, F> intersector(parameters.scene);
    Ray<Real> stack[Capacity];
    FilmSum sum;
    RayCounts rays;
    trace_sample<Count>(model, intersector, parameters.format,
                        camera_ray(camera, pixel, sample, parameters.settings.seed), stack, sum,
                        rays);
    add_to_film(parameters, pixel, sum);
    if constexpr (Count) {
        atomicAdd(&parameters.rays->camera, rays.camera);
        atomicAdd(&parameters.rays->shadow, rays.shadow);
        atomicAdd(&parameters.rays->ambient, rays.ambient);
        atomicAdd(&parameters.rays->bounce, rays.bounce);
    }
}

}  // namespace haste
