#pragma once

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "core/engine/depth_first.h"
#include "core/sampling/camera_ray.h"
#include "cpu/render.h"

namespace haste {

/// One worker's pieces of the result.
struct WorkerTally {
    RayCounts rays;
    FilmFaults faults;

    void add_faults(const FilmSum& sum, u32 pixel) {
        faults.non_finite += sum.non_finite;
        if (sum.overflow) faults.overflow_pixel = std::min(faults.overflow_pixel, pixel);
    }

    void fold_into(PassResult& result) const {
        result.rays += rays;
        result.film.faults.non_finite += faults.non_finite;
        result.film.faults.overflow_pixel =
            std::min(result.film.faults.overflow_pixel, faults.overflow_pixel);
    }
};

/// One worker owns a pixel: all its samples in registers, no atomics.
template <class Model, class I, bool Count, class Real>
PassResult depth_first_pass(const PassRequest& request, const Camera<Real>& camera,
                            const Model& model, const I& intersector) {
    const u32 pixels = request.view.camera.width * request.view.camera.height;
    PassResult result;
    result.film.sums.assign(3 * std::size_t(pixels), 0);
    tbb::enumerable_thread_specific<WorkerTally> tallies;
    tbb::enumerable_thread_specific<std::vector<Ray<Real>>> stacks(
        [&] { return std::vector<Ray<Real>>(request.stack_capacity); });
    constexpr u32 pixels_per_task = 16;
    tbb::parallel_for(tbb::blocked_range<u32>(0, pixels, pixels_per_task),
                      [&](const tbb::blocked_range<u32>& range) {
                          WorkerTally& tally = tallies.local();
                          Ray<Real>* stack = stacks.local().data();
                          for (u32 pixel = range.begin(); pixel < range.end(); ++pixel) {
                              FilmSum sum;
                              for (u32 i = 0; i < request.samples; ++i) {
                                  const Ray<Real> ray =
                                      camera_ray(camera, pixel, request.first_sample + i,
                                                 request.settings.seed);
                                  trace_sample<Count>(model, intersector, request.format, ray,
                                                      stack, sum, tally.rays);
                              }
                              tally.add_faults(sum, pixel);
                              for (int c = 0; c < 3; ++c) {
                                  result.film.sums[3 * std::size_t(pixel) + c] = sum.channel[c];
                              }
                          }
                      });
    for (const WorkerTally& tally : tallies) tally.fold_into(result);
    return result;
}

}  // namespace haste
