#include "cuda/engines/wavefront.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "core/accel/bvh8_intersector.h"
#include "cuda/kernels/resident_params.h"

namespace haste::cuda {

namespace {

/// Packets between two looks at the flag: one group is always queued behind the one that runs.
constexpr int packets_per_group = 4;

}  // namespace

WavefrontEngine::Room::Room(const EngineRequest& request) {
    constexpr u64 ray = sizeof(Ray<float>);
    constexpr u64 most_waiting = u64(1) << 30;      // places are counted in 32 bits, a turn too far
    constexpr u64 most_shadows = u64(0xf0000000u);  // as a warp may count beyond the last
    const u64 bytes = request.schedule.queue_bytes;
    const u64 each = WavefrontParams::packet_ray_bytes(request.most_shadow_rays);
    const u64 need = request.tree.lifo_need();
    if (bytes < need * ray + each) {
        throw std::invalid_argument("queue_bytes must be at least " +
                                    std::to_string(need * ray + each) +
                                    " for the rays of one sample and the hit and shadow rays of "
                                    "one ray, not " +
                                    std::to_string(bytes));
    }
    packet = std::min({request.schedule.packet, std::max<u64>(bytes / 2 / each, 1),
                       (bytes - need * ray) / each,
                       most_shadows / std::max<u64>(request.most_shadow_rays, 1)});
    // More than the packets can grow to would never be used.
    queue = std::min({most_waiting, (bytes - packet * each) / ray, 2 * need * packet});
}

WavefrontEngine::WavefrontEngine(const EngineRequest& request)
    : Engine(request),
      plan_(kernel("wavefront_plan")),
      closest_hit_(kernel("wavefront_closest_hit")),
      steps_{step("wavefront_generate"), tracing_step("wavefront_closest_hit"),
             step("wavefront_shade"), step("wavefront_close_gap"),
             tracing_step("wavefront_any_hit")},
      room_(request),
      queue_(room_.queue + room_.packet),
      hits_(room_.packet),
      shadow_ways_(room_.packet * request.most_shadow_rays),
      shadow_lights_(shadow_ways_.size()),
      shadow_roundings_(shadow_ways_.size()),
      state_(1),
      seen_(2) {}

WavefrontEngine::Step WavefrontEngine::step(const std::string& name) const {
    const Kernel& one = kernel(name);
    return {one, {.blocks = resident_grid(one), .threads = request_.schedule.block}};
}

WavefrontEngine::Step WavefrontEngine::tracing_step(const std::string& name) const {
    if (request_.kernel.traversal != name_of(TraversalKind::bvh8)) return step(name);
    const Kernel& one = kernel(name);
    const int block = std::min(request_.schedule.block, max_resident_block);
    const std::size_t stacks = std::size_t(block) * shared_stack_entries * sizeof(Bvh8Group);
    return {one,
            {.blocks = resident_grid(one, block, stacks),
             .threads = block,
             .dynamic_shared_bytes = stacks}};
}

EnginePass WavefrontEngine::run(const RenderParams& pass) {
    Stream& stream = request_.stream;
    const WavefrontParams parameters{
        .render = pass,
        .admission = Admission(request_.tree, room_.queue, room_.packet),
        .camera_rays = pass.range.count(pass.scene.camera),
        .queue = queue_.data(),
        .queue_size = u32(queue_.size()),
        .hits = hits_.data(),
        .shadows = {shadow_ways_.data(), shadow_lights_.data(), shadow_roundings_.data()},
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
    return {seconds, last.peak_bytes, one_launch(seconds, last.packets)};
}

void WavefrontEngine::launch_packet(const WavefrontParams& parameters) {
    Stream& stream = request_.stream;
    plan_.launch({.blocks = 1, .threads = 1}, stream, parameters);
    for (const Step& step : steps_) step.kernel.launch(step.shape, stream, parameters);
}

}  // namespace haste::cuda
