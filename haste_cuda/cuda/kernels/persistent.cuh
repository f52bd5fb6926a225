#pragma once

#include "core/engine/depth_first.h"
#include "cuda/kernels/config.cuh"
#include "cuda/kernels/persistent_params.h"

namespace haste {

/// A stack of one ray, which stays in registers: nothing indexes it.
struct OneRay {
    Ray<float> ray;
    u32 depth = 0;

    __device__ void push(const Ray<float>& child) {
        ray = child;
        depth = 1;
    }
    __device__ Ray<float> pop() {
        depth = 0;
        return ray;
    }
};

/// Consecutive samples of one pixel: a lane's share of the work that is not yet begun.
struct SampleRun {
    u32 pixel = 0;
    u32 next = 0;
    u32 end = 0;
    bool last = false;  ///< there are no more

    __device__ bool empty() const { return next == end; }

    /// Fetches a run for each lane that calls, if there is one left.
    __device__ void fetch(const PersistentParams& parameters) {
        const u64 run = claim(parameters.next_run);
        last = run >= parameters.runs;
        if (last) return;
        const RenderParams& render = parameters.render;
        const Camera<float>& camera = render.scene.camera;
        const u32 pixels = camera.width * camera.height;
        pixel = SampleRange::pixel(camera, u32(run % pixels));
        next = u32(run / pixels) * parameters.run_samples;
        end = min(next + parameters.run_samples, render.range.samples);
    }

    __device__ Ray<float> take(const RenderParams& render) {
        return camera_ray(render.scene.camera, pixel, render.range.first_sample + next++,
                          render.range.seed);
    }
};

/// Adds up what one pixel receives from consecutive rays of a lane.
template <class C>
struct PixelSum {
    typename C::Sum sum;
    u32 pixel = 0;

    __device__ void turn_to(const FilmTarget& film, u32 next_pixel) {
        if (next_pixel == pixel) return;
        flush(film);
        pixel = next_pixel;
    }

    __device__ void flush(const FilmTarget& film) {
        add_to_film(film, pixel, pixel, sum);
        sum = typename C::Sum();
    }
};

/// Resident threads: a lane that has no ray left begins a sample, until there is none (Aila and
/// Laine, Understanding the Efficiency of Ray Traversal on GPUs, HPG 2009; Novák, Havran and
/// Dachsbacher, Path Regeneration for Interactive Path Tracing, 2010).
///
/// Children wait on the stack of the lane that spawned them. Lanes of a warp could share them, but
/// each would then turn from pixel to pixel and pay three atomic adds a ray.
template <class C, class Stack>
__device__ void persistent(const PersistentParams& parameters, Stack& waiting) {
    const RenderParams& render = parameters.render;
    const typename C::Model model(render.scene, render.settings);
    const typename C::Intersector intersector(render.scene);
    SampleRun run;
    PixelSum<C> light;
    RayCounts rays;
    for (;;) {
        if (waiting.depth == 0) {
            if (run.empty() && !run.last) run.fetch(parameters);
            if (!run.empty()) {
                light.turn_to(render.film, run.pixel);
                waiting.push(run.take(render));
            }
        }
        if (!__any_sync(whole_warp, waiting.depth > 0)) break;
        if (waiting.depth > 0) {
            const Ray<float> ray = waiting.pop();
            KernelTraceOut<C, Stack&> out{intersector, render.film.format, light.sum, rays,
                                          waiting};
            out.trace(model, ray);
        }
        __syncwarp();
    }
    light.flush(render.film);
    if constexpr (C::count) add_counts(render.rays, rays);
}

template <class C>
__device__ void persistent(const PersistentParams& parameters) {
    if constexpr (C::Model::max_children == 1) {
        OneRay waiting;
        persistent<C>(parameters, waiting);
    } else {
        Ray<float> memory[C::stack_capacity];
        RayStack<float> waiting{memory};
        persistent<C>(parameters, waiting);
    }
}

}  // namespace haste
