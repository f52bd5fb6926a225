#include "cuda/engines/wavefront.h"

#include <algorithm>

namespace haste::cuda {

namespace {

/// Packets between two looks at the flag: one group is always queued behind the one that runs.
constexpr int packets_per_group = 4;

/// A queue of what the packets can grow to, within the schedule's bytes: more would never be used.
u64 queue_capacity(const EngineRequest& request) {
    constexpr u64 countable = 0xffffffffu;
    return std::min({countable, request.schedule.queue_bytes / sizeof(Ray<float>),
                     2 * request.tree.lifo_need() * request.schedule.packet});
}

}  // namespace

WavefrontEngine::WavefrontEngine(const EngineRequest& request)
    : Engine(request),
      plan_(kernel("wavefront_plan")),
      closest_hit_(kernel("wavefront_closest_hit")),
      capacity_(queue_capacity(request)),
      queue_(capacity_),
      packet_(request.schedule.packet),
      hits_(request.schedule.packet),
      shadows_(request.schedule.packet * request.most_shadow_rays),
      state_(1),
      seen_(2) {
    for (const char* name :
         {"wavefront_generate", "wavefront_closest_hit", "wavefront_shade", "wavefront_any_hit"}) {
        const Kernel& step = kernel(name);
        steps_.push_back({step, resident_grid(step)});
    }
}

EnginePass WavefrontEngine::run(const RenderParams& pass) {
    Stream& stream = request_.stream;
    const WavefrontParams parameters{
        .render = pass,
        .admission = Admission(request_.tree, capacity_, request_.schedule.packet),
        .camera_rays = pass.range.count(pass.scene.camera),
        .queue = queue_.data(),
        .packet = packet_.data(),
        .hits = hits_.data(),
        .shadows = shadows_.data(),
        .state = state_.data()};
    start_.record(stream);
    state_.clear(stream);
    for (u64 group = 0;; ++group) {
        for (int i = 0; i < packets_per_group; ++i) launch_packet(parameters);
        state_.download(seen_.front(2).subspan(group % 2, 1), stream);
        group_done_[group % 2].record(stream);
        if (group == 0) continue;
        const u64 before = (group - 1) % 2;
        group_done_[before].synchronize();
        if (seen_.data()[before].done) break;
    }
    end_.record(stream);
    const double seconds = seconds_between(start_, end_);
    const WavefrontState& last = seen_.data()[0];
    return {seconds, last.peak * sizeof(Ray<float>), one_launch(seconds, last.packets)};
}

void WavefrontEngine::launch_packet(const WavefrontParams& parameters) {
    Stream& stream = request_.stream;
    plan_.launch({.blocks = 1, .threads = 1}, stream, parameters);
    for (const Step& step : steps_) {
        step.kernel.launch({.blocks = step.blocks, .threads = request_.schedule.block}, stream,
                           parameters);
    }
}

}  // namespace haste::cuda
