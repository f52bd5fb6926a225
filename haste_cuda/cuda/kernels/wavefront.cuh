#pragma once

#include "cuda/kernels/config.cuh"
#include "cuda/kernels/resident.cuh"
#include "cuda/kernels/wavefront_params.h"

namespace haste {

/// The threads of a grid share the items of a list whose length only the device knows.
struct GridLoop {
    u32 first = blockIdx.x * blockDim.x + threadIdx.x;
    u32 step = gridDim.x * blockDim.x;
};

/// A structure of whole 16-byte words, loaded by as many instructions.
template <class T>
__device__ T load_words(const T& from) {
    struct Words {
        uint4 word[sizeof(T) / sizeof(uint4)];
    } words;
    for (u32 i = 0; i < sizeof(T) / sizeof(uint4); ++i) {
        words.word[i] = reinterpret_cast<const uint4*>(&from)[i];
    }
    return __builtin_bit_cast(T, words);
}

/// Step 1, one thread: decides what the next packet is made of.
template <class C>
__device__ void wavefront_plan(const WavefrontParams& parameters) {
    WavefrontState& state = *parameters.state;
    const u64 bytes = u64(state.rest + state.packet + state.children) * sizeof(Ray<float>) +
                      u64(state.packet) * sizeof(Hit<float>) +
                      u64(state.shadows) * ShadowList::ray_bytes;
    if (bytes > state.peak_bytes) state.peak_bytes = bytes;
    plan_packet(state, parameters.admission, parameters.camera_rays, parameters.queue_size);
}

/// Step 2: makes the camera rays.
template <class C>
__device__ void wavefront_generate(const WavefrontParams& parameters) {
    const WavefrontState& state = *parameters.state;
    const RenderParams& render = parameters.render;
    const u64 first_camera_ray = state.next_camera_ray - (state.packet - state.pending);
    const GridLoop grid;
    for (u32 i = state.pending + grid.first; i < state.packet; i += grid.step) {
        parameters.ray(state.packet_start + i) =
            render.range.ray(render.scene.camera, first_camera_ray + (i - state.pending));
    }
}

/// The rays of the packet, and where their hits go.
struct ClosestHitTask {
    static constexpr bool any_hit = false;
    using Start = AtOrigin<float>;
    const WavefrontParams& parameters;

    __device__ u32 count() const { return __ldg(&parameters.state->packet); }
    __device__ u32* next() const { return &parameters.state->next_ray; }

    __device__ static Start t_min(const RayQuery<float>&) { return {}; }

    __device__ RayQuery<float> load(u32 index) const {
        const auto* words = reinterpret_cast<const float4*>(
            &parameters.ray(__ldg(&parameters.state->packet_start) + index));
        const float4 a = __ldcs(words), b = __ldcs(words + 1);
        return {{a.x, a.y, a.z}, 0.0f, {a.w, b.x, b.y}, Numeric<float>::infinity};
    }

    __device__ void note(u32 index, const Hit<float>& hit) const {
        reinterpret_cast<float4*>(parameters.hits)[index] = {hit.t, hit.b1, hit.b2,
                                                             bits_float(hit.primitive)};
    }

    __device__ u32 noted(u32 index) const { return parameters.hits[index].primitive; }
};

/// Step 3: the closest hit of every ray.
template <class C>
__device__ void wavefront_closest_hit(const WavefrontParams& parameters) {
    const SceneView<float>& scene = parameters.render.scene;
    if constexpr (C::resident) {
        trace_resident<ClosestHitTask, typename C::Features, typename C::Precision>(scene,
                                                                                    {parameters});
    } else {
        const typename C::Intersector intersector(scene);
        const WavefrontState& state = *parameters.state;
        const u32 packet = state.packet;
        const GridLoop grid;
        for (u32 i = grid.first; i < packet; i += grid.step) {
            parameters.hits[i] = intersector.closest(parameters.ray(state.packet_start + i));
        }
    }
}

/// Receives what a model sends out while nothing is traced.
template <class C>
struct ShadeOut {
    const WavefrontParams& parameters;
    typename C::Sum& sum;

    __device__ void radiance(const Ray<float>&, const Vec3<float>& value, u32 rounding) {
        sum.add(parameters.render.film.format, value, rounding);
    }
    __device__ void shadow(const ShadowRay<float>& ray) {
        parameters.shadows.put(claim(&parameters.state->shadows), ray);
    }
    __device__ void child(const Ray<float>& ray) {
        parameters.ray(parameters.state->child_start + claim(&parameters.state->children)) = ray;
    }
};

/// Step 4: shades every hit; children go to the queue, shadow rays to a list of their own.
template <class C>
__device__ void wavefront_shade(const WavefrontParams& parameters) {
    const RenderParams& render = parameters.render;
    const typename C::Model model(render.scene, render.settings);
    const u32 packet = parameters.state->packet;
    RayCounts rays;
    const GridLoop grid;
    for (u32 i = grid.first; i < packet; i += grid.step) {
        const Ray<float> ray = load_words(parameters.ray(parameters.state->packet_start + i));
        if constexpr (C::count) rays.count(ray);
        const Hit<float> hit = load_words(parameters.hits[i]);
        typename C::Sum sum;
        ShadeOut<C> out{parameters, sum};
        if (hit.found()) {
            model.shade(ray, hit, out);
        } else {
            model.miss(ray, out);
        }
        add_to_film(render.film, ray.pixel, ray.pixel, sum);
    }
    if constexpr (C::count) add_counts(render.rays, rays);
}

/// Where the packet was above older rays, the youngest children close the gap. Apart from the
/// kernel, whose registers it would take.
__device__ __noinline__ void close_gap(const WavefrontParams& parameters) {
    const WavefrontState& state = *parameters.state;
    const u32 moved = min(state.gap, state.children);
    const u32 from = state.child_start + (state.children - moved);
    constexpr u32 words = sizeof(Ray<float>) / sizeof(uint4);
    const GridLoop grid;
    for (u32 i = grid.first; i < words * moved; i += grid.step) {
        const auto word = [&](u32 place) {
            return reinterpret_cast<uint4*>(&parameters.ray(place + i / words)) + i % words;
        };
        *word(state.packet_start) = *word(from);
    }
}

/// The shadow rays of the packet; what is not blocked reaches the film.
template <class C>
struct AnyHitTask {
    static constexpr bool any_hit = true;
    using Start = AtOrigin<float>;
    const WavefrontParams& parameters;

    __device__ u32 count() const { return __ldg(&parameters.state->shadows); }
    __device__ u32* next() const { return &parameters.state->next_shadow; }

    __device__ static Start t_min(const RayQuery<float>&) { return {}; }

    __device__ RayQuery<float> load(u32 index) const {
        const auto* words = reinterpret_cast<const float4*>(parameters.shadows.ways + index);
        const float4 a = __ldcs(words), b = __ldcs(words + 1);
        return {{a.x, a.y, a.z}, 0.0f, {b.x, b.y, b.z}, a.w};
    }

    /// The owner is looked up here, for a lane that kept it would want a register more.
    __device__ bool blocks(u32 index, u32 shape, float t, float t_max) const {
        return t < t_max && shape != __ldg(&parameters.shadows.ways[index].owner);
    }

    __device__ void note(u32, const Hit<float>&) const {}

    __device__ void miss(u32 index) const {
        const FilmTarget& film = parameters.render.film;
        const float4 light =
            __ldcs(reinterpret_cast<const float4*>(parameters.shadows.lights) + index);
        const u32 pixel = float_bits(light.w);
        typename C::Sum sum;
        sum.add(film.format, Vec3<float>{light.x, light.y, light.z},
                __ldcs(parameters.shadows.roundings + index));
        add_to_film(film, pixel, pixel, sum);
    }
};

/// Step 5: what no shadow ray finds blocked reaches the film. Queues have no gap but near their
/// limit, and a kernel of its own for that would cost every packet a launch.
template <class C>
__device__ void wavefront_any_hit(const WavefrontParams& parameters) {
    close_gap(parameters);
    const RenderParams& render = parameters.render;
    const GridLoop grid;
    const u32 shadows = parameters.state->shadows;
    if constexpr (C::count) {
        if (grid.first == 0) atomicAdd(&render.rays->shadow, u64(shadows));
    }
    if constexpr (C::resident) {
        trace_resident<AnyHitTask<C>, typename C::Features, typename C::Precision>(render.scene,
                                                                                   {parameters});
    } else {
        const typename C::Intersector intersector(render.scene);
        for (u32 i = grid.first; i < shadows; i += grid.step) {
            const ShadowRay<float> ray = parameters.shadows.get(i);
            if (intersector.occluded(ray)) continue;
            typename C::Sum sum;
            sum.add(render.film.format, ray.value, ray.rounding);
            add_to_film(render.film, ray.pixel, ray.pixel, sum);
        }
    }
}

}  // namespace haste
