#include "cuda/engines/persistent.h"

#include <algorithm>

namespace haste::cuda {

PersistentEngine::PersistentEngine(const EngineRequest& request)
    : Engine(request),
      kernel_(kernel("persistent")),
      blocks_(resident_grid(kernel_)),
      next_run_(1) {}

EnginePass PersistentEngine::run(const RenderParams& pass) {
    Stream& stream = request_.stream;
    const u64 pixels = u64(pass.scene.camera.width) * pass.scene.camera.height;
    const u64 lanes = blocks_ * u64(request_.schedule.block);
    // Long runs touch the film and the counter less often, short ones end more evenly.
    constexpr u64 longest_run = 16;
    constexpr u64 runs_per_lane = 16;
    const u64 samples = pass.range.samples;
    const u64 run = std::clamp<u64>(pixels * samples / (lanes * runs_per_lane), 1,
                                    std::min<u64>(longest_run, samples));
    const PersistentParams parameters{.render = pass,
                                      .run_samples = u32(run),
                                      .runs = pixels * ((samples + run - 1) / run),
                                      .next_run = next_run_.data()};
    next_run_.clear(stream);
    start_.record(stream);
    kernel_.launch({.blocks = blocks_, .threads = request_.schedule.block}, stream, parameters);
    end_.record(stream);
    const double seconds = seconds_between(start_, end_);
    return {seconds, 0, one_launch(seconds)};
}

}  // namespace haste::cuda
