#include "cuda/engines/wavefront.h"

#include <algorithm>
#include <span>

#include "core/accel/bvh8_intersector.h"
#include "cuda/kernels/resident_params.h"

namespace haste::cuda {

WavefrontEngine::Lane::Lane(const WavefrontRoom& room, u64 most_shadow_rays)
    : queue(room.queue + room.packet),
      hits(room.packet),
      shadow_ways(room.packet * most_shadow_rays),
      shadow_lights(shadow_ways.size()),
      shadow_roundings(shadow_ways.size()),
      state(1),
      seen(2) {}

void WavefrontEngine::Lane::start(const RenderParams& pass, const Admission& admission, u64 first,
                                  u64 end) {
    parameters = WavefrontParams{
        .render = pass,
        .admission = admission,
        .camera_rays = end,
        .queue = queue.data(),
        .queue_size = u32(queue.size()),
        .hits = hits.data(),
        .shadows = {shadow_ways.data(), shadow_lights.data(), shadow_roundings.data()},
        .state = state.data()};
    launched = 0;
    done = false;
    WavefrontState& fresh = seen.data()[0];
    fresh = {};
    fresh.next_camera_ray = first;
    state.upload(seen.front(1), stream);
}

WavefrontEngine::WavefrontEngine(const EngineRequest& request)
    : Engine(request),
      plan_(kernel("wavefront_plan")),
      closest_hit_(kernel("wavefront_closest_hit")),
      steps_{step("wavefront_generate"), tracing_step("wavefront_closest_hit"),
             step("wavefront_shade"), tracing_step("wavefront_any_hit")},
      room_(WavefrontRoom::fit(request.tree, request.schedule.queue_bytes, request.schedule.packet,
                               request.schedule.streams, request.most_shadow_rays)) {
    for (u64 i = 0; i < room_.lanes; ++i) lanes_.emplace_back(room_, request.most_shadow_rays);
}

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
    const u64 camera_rays = pass.range.count(pass.scene.camera);
    // Half a packet of samples, and what they spawn, are worth a lane.
    const u64 used = std::clamp<u64>(2 * camera_rays / room_.packet, 1, lanes_.size());
    const std::span<Lane> lanes(lanes_.data(), used);
    const Admission admission(request_.tree, room_.queue, room_.packet);
    start_.record(lanes.front().stream);
    for (u64 i = 0; i < used; ++i) {
        lanes[i].start(pass, admission, camera_rays * i / used, camera_rays * (i + 1) / used);
    }
    while (!std::ranges::all_of(lanes, &Lane::done)) {
        for (Lane& lane : lanes) {
            if (!lane.done) advance(lane);
        }
    }
    EnginePass result;
    u64 packets = 0;
    for (const Lane& lane : lanes) {
        // The packet that was found to be empty; one more is behind it.
        const u64 last = (lane.launched - 2) % 2;
        result.seconds = std::max(result.seconds, seconds_between(start_, lane.looked[last]));
        result.peak_queue_bytes += lane.seen.data()[last].peak_bytes;
        packets += lane.seen.data()[last].packets;
        lane.stream.synchronize();
    }
    result.work = one_launch(result.seconds, packets);
    return result;
}

void WavefrontEngine::advance(Lane& lane) const {
    plan_.launch({.blocks = 1, .threads = 1}, lane.stream, *lane.parameters);
    for (const Step& step : steps_) {
        step.kernel.launch(step.shape, lane.stream, *lane.parameters);
    }
    const u64 own = lane.launched++ % 2;
    lane.state.download(lane.seen.front(2).subspan(own, 1), lane.stream);
    lane.looked[own].record(lane.stream);
    if (lane.launched == 1) return;
    const u64 before = 1 - own;
    lane.looked[before].synchronize();
    lane.done = lane.seen.data()[before].done != 0;
}

}  // namespace haste::cuda
