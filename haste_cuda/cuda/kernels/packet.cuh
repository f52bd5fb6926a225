#pragma once

#include "cuda/kernels/config.cuh"
#include "cuda/kernels/packet_params.h"

namespace haste {

/// The paper's kernel: one thread a ray. Finds the closest hit, shades it, settles its shadow rays
/// and hands back what it spawned.
template <class C>
__device__ void packet(const PacketParams& parameters) {
    const u32 index = blockIdx.x * blockDim.x + threadIdx.x;
    if (index >= parameters.ray_count + parameters.camera_ray_count) return;
    const RenderParams& render = parameters.render;
    const Ray<float> ray =
        index < parameters.ray_count
            ? parameters.rays[index]
            : render.range.ray(render.scene.camera,
                               parameters.first_camera_ray + (index - parameters.ray_count));
    const typename C::Model model(render.scene, render.settings);
    const typename C::Intersector intersector(render.scene);
    typename C::Sum sum;
    RayCounts rays;
    KernelTraceOut<C, CompactRays<C>> out{
        intersector, render.film.format, sum, rays, {parameters.children, parameters.child_count}};
    out.trace(model, ray);
    add_to_film(render.film, film_place<C>(render, ray.pixel, ray.layer), ray.pixel, sum);
    if constexpr (C::count) add_counts(render.rays, rays);
}

}  // namespace haste
