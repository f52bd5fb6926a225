#pragma once

#include "cuda/kernels/config.cuh"
#include "cuda/kernels/persistent_params.h"

namespace haste {

/// The queue of one warp, last in, first out. Lanes push whenever they spawn a ray; the warp pops
/// together.
struct WarpQueue {
    Ray<float>* rays;
    u32* size;  ///< in shared memory

    __device__ void push(const Ray<float>& ray) { rays[atomicAdd(size, 1u)] = ray; }

    /// Gives each lane that asks one of the newest rays while there are some; whether it got one.
    /// The whole warp calls together.
    __device__ bool pop(bool asks, Ray<float>& ray) {
        __syncwarp();
        const u32 waiting = *size;
        const u32 asking = __ballot_sync(whole_warp, asks);
        const u32 rank = __popc(asking & lanes_below());
        const bool served = asks && rank < waiting;
        if (served) ray = rays[waiting - 1 - rank];
        __syncwarp();
        if (lane_index() == 0) *size = waiting - min(waiting, u32(__popc(asking)));
        __syncwarp();
        return served;
    }
};

/// The ray that a lane goes on with.
struct OneRay {
    Ray<float> ray;
    bool full = false;

    __device__ void push(const Ray<float>& child) {
        ray = child;
        full = true;
    }
};

/// A lane goes on with the first child of its ray, which has the same pixel; the warp's queue gets
/// the siblings.
struct FirstChild {
    OneRay& own;
    WarpQueue& queue;

    __device__ void push(const Ray<float>& child) {
        if (own.full) {
            queue.push(child);
        } else {
            own.push(child);
        }
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

/// Resident threads: a lane that has no ray takes one from its warp's queue or begins a sample,
/// until neither is left (Aila and Laine, Understanding the Efficiency of Ray Traversal on GPUs,
/// HPG 2009; Novák, Havran and Dachsbacher, Path Regeneration for Interactive Path Tracing, 2010).
///
/// The queue is bounded as `Admission` shows: its packets are the 32 rays of a warp, which are the
/// newest, for the lanes' own are first children of the packet before and the others come from the
/// queue's end. Samples begin only while it is empty, so it never holds more than 32 lifo_need()
/// rays.
template <class C>
__device__ void persistent(const PersistentParams& parameters) {
    constexpr bool tree = C::Model::max_children > 1;
    constexpr u32 most_warps = 1024 / warp_size;
    __shared__ u32 waiting[tree ? most_warps : 1];
    const RenderParams& render = parameters.render;
    const typename C::Model model(render.scene, render.settings);
    const typename C::Intersector intersector(render.scene);
    const u32 warp = threadIdx.x / warp_size;
    const u64 all_warps = u64(blockIdx.x) * (blockDim.x / warp_size) + warp;
    WarpQueue queue{parameters.queues + all_warps * parameters.queue_capacity,
                    waiting + (tree ? warp : 0)};
    if (tree && lane_index() == 0) *queue.size = 0;

    OneRay own;
    SampleRun run;
    PixelSum<C> light;
    RayCounts rays;
    for (;;) {
        if constexpr (tree) own.full |= queue.pop(!own.full, own.ray);
        if (!own.full && run.empty() && !run.last) run.fetch(parameters);
        if (!own.full && !run.empty()) own.push(run.take(render));
        if (!__any_sync(whole_warp, own.full)) break;
        if (own.full) {
            const Ray<float> ray = own.ray;
            own.full = false;
            light.turn_to(render.film, ray.pixel);
            if constexpr (tree) {
                KernelTraceOut<C, FirstChild> out{
                    intersector, render.film.format, light.sum, rays, {own, queue}};
                out.trace(model, ray);
            } else {
                KernelTraceOut<C, OneRay&> out{intersector, render.film.format, light.sum, rays,
                                               own};
                out.trace(model, ray);
            }
        }
        __syncwarp();
    }
    light.flush(render.film);
    if constexpr (C::count) add_counts(render.rays, rays);
}

}  // namespace haste
