#pragma once

#include "cuda/kernels/config.cuh"

namespace haste {

/// One thread a sample, private stack: the mega-kernel.
template <class C>
__device__ void depth_first(const RenderParams& parameters) {
    const u64 index = u64(blockIdx.x) * blockDim.x + threadIdx.x;
    const Camera<float>& camera = parameters.scene.camera;
    if (index >= parameters.range.count(camera)) return;
    const typename C::Model model(parameters.scene, parameters.settings);
    const typename C::Intersector intersector(parameters.scene);
    const Ray<float> ray = parameters.range.ray(camera, index);
    const u32 pixel = ray.pixel;
    Ray<float> stack[C::stack_capacity];
    typename C::Sum sum;
    RayCounts rays;
    trace_sample<C::count>(model, intersector, parameters.film.format, ray, stack, sum, rays);
    add_to_film(parameters.film, pixel, pixel, sum);
    if constexpr (C::count) add_counts(parameters.rays, rays);
}

}  // namespace haste
