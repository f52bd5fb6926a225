#pragma once

#include "cuda/kernels/config.cuh"
#include "cuda/kernels/wavefront_params.h"

namespace haste {

/// The threads of a grid share the items of a list whose length only the device knows.
struct GridLoop {
    u32 first = blockIdx.x * blockDim.x + threadIdx.x;
    u32 step = gridDim.x * blockDim.x;
};

/// Step 1, one thread: decides what the next packet is made of.
template <class C>
__device__ void wavefront_plan(const WavefrontParams& parameters) {
    WavefrontState& state = *parameters.state;
    const PacketPlan plan =
        parameters.admission.next(state.waiting, parameters.camera_rays - state.next_camera_ray);
    // What the step before wrote is read for the last time here.
    state.next_camera_ray += plan.born;
    state.peak = state.waiting > state.peak ? state.waiting : state.peak;
    state.waiting -= u32(plan.pending);
    state.packet_start = state.waiting;
    state.pending = u32(plan.pending);
    state.packet = u32(plan.size());
    state.shadows = 0;
    state.done = plan.size() == 0;
    if (!state.done) ++state.packets;
}

/// Step 2: moves the pending rays out of the way of their children and makes the camera rays.
template <class C>
__device__ void wavefront_generate(const WavefrontParams& parameters) {
    const WavefrontState& state = *parameters.state;
    const RenderParams& render = parameters.render;
    const u64 first_camera_ray = state.next_camera_ray - (state.packet - state.pending);
    const GridLoop grid;
    for (u32 i = grid.first; i < state.packet; i += grid.step) {
        parameters.packet[i] =
            i < state.pending
                ? parameters.queue[state.packet_start + i]
                : render.range.ray(render.scene.camera, first_camera_ray + (i - state.pending));
    }
}

/// Step 3: the closest hit of every ray.
template <class C>
__device__ void wavefront_closest_hit(const WavefrontParams& parameters) {
    const typename C::Intersector intersector(parameters.render.scene);
    const u32 packet = parameters.state->packet;
    const GridLoop grid;
    for (u32 i = grid.first; i < packet; i += grid.step) {
        parameters.hits[i] = intersector.closest(parameters.packet[i]);
    }
}

/// Receives what a model sends out while nothing is traced.
template <class C>
struct ShadeOut {
    const FixedPoint& format;
    typename C::Sum& sum;
    CompactRays<C> children;
    ShadowRay<float>* shadows;
    u32* shadow_count;

    __device__ void radiance(const Ray<float>&, const Vec3<float>& value, u32 rounding) {
        sum.add(format, value, rounding);
    }
    __device__ void shadow(const ShadowRay<float>& ray) { shadows[claim(shadow_count)] = ray; }
    __device__ void child(const Ray<float>& ray) { children.push(ray); }
};

/// Step 4: shades every hit; children go to the queue, shadow rays to a list of their own.
template <class C>
__device__ void wavefront_shade(const WavefrontParams& parameters) {
    const RenderParams& render = parameters.render;
    const typename C::Model model(render.scene, render.settings);
    WavefrontState& state = *parameters.state;
    const u32 packet = state.packet;
    RayCounts rays;
    const GridLoop grid;
    for (u32 i = grid.first; i < packet; i += grid.step) {
        const Ray<float> ray = parameters.packet[i];
        if constexpr (C::count) rays.count(ray);
        const Hit<float> hit = parameters.hits[i];
        typename C::Sum sum;
        ShadeOut<C> out{render.film.format,
                        sum,
                        {parameters.queue, &state.waiting},
                        parameters.shadows,
                        &state.shadows};
        if (hit.found()) {
            model.shade(ray, hit, out);
        } else {
            model.miss(ray, out);
        }
        add_to_film(render.film, ray.pixel, ray.pixel, sum);
    }
    if constexpr (C::count) add_counts(render.rays, rays);
}

/// Step 5: what no shadow ray finds blocked reaches the film.
template <class C>
__device__ void wavefront_any_hit(const WavefrontParams& parameters) {
    const RenderParams& render = parameters.render;
    const typename C::Intersector intersector(render.scene);
    const u32 shadows = parameters.state->shadows;
    RayCounts rays;
    const GridLoop grid;
    for (u32 i = grid.first; i < shadows; i += grid.step) {
        const ShadowRay<float> ray = parameters.shadows[i];
        if constexpr (C::count) ++rays.shadow;
        if (intersector.occluded(ray)) continue;
        typename C::Sum sum;
        sum.add(render.film.format, ray.value, ray.rounding);
        add_to_film(render.film, ray.pixel, ray.pixel, sum);
    }
    if constexpr (C::count) add_counts(render.rays, rays);
}

}  // namespace haste
