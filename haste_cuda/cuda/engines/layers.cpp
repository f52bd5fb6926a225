#include "cuda/engines/layers.h"

#include <algorithm>
#include <numeric>

namespace haste::cuda {

LayersEngine::LayersEngine(const EngineRequest& request)
    : Engine(request),
      kernel_(kernel("packet")),
      plan_(LayerPlan::fit(request.tree, request.schedule.queue_bytes / sizeof(Ray<float>),
                           request.schedule.packet)),
      child_count_(1),
      waiting_(request.tree.generations + 1) {
    for (u32 i = 1; i < request.tree.generations; ++i) buffers_.emplace_back(plan_.buffer);
}

EnginePass LayersEngine::run(const RenderParams& pass) {
    WorkLog log(request_.schedule.record_spans);
    u64 launches = 0;
    const u64 camera_rays = pass.range.count(pass.scene.camera);
    u64 peak = 0;
    const auto note_peak = [&] {
        peak = std::max(peak, std::accumulate(waiting_.begin(), waiting_.end(), u64(0)));
    };
    for (u64 first = 0; first < camera_rays; first += plan_.slice) {
        PacketParams slice{};
        slice.render = pass;
        slice.first_camera_ray = first;
        slice.camera_ray_count = u32(std::min(plan_.slice, camera_rays - first));
        trace(slice, 0, log);
        ++launches;
        note_peak();
        slice.camera_ray_count = 0;
        std::size_t deepest = 1;
        while (deepest > 0) {
            if (waiting_[deepest] == 0) {
                --deepest;
                continue;
            }
            slice.ray_count = u32(std::min<u64>(plan_.slice, waiting_[deepest]));
            waiting_[deepest] -= slice.ray_count;
            slice.rays = buffers_[deepest - 1].data() + waiting_[deepest];
            trace(slice, deepest, log);
            ++launches;
            note_peak();
            if (waiting_[deepest + 1] > 0) ++deepest;
        }
    }
    return {log.seconds(),
            peak * sizeof(Ray<float>),
            {.launches = launches, .bytes_moved = launches * sizeof(u32), .spans = log.take()}};
}

void LayersEngine::trace(const PacketParams& slice, std::size_t generation, WorkLog& log) {
    PacketParams parameters = slice;
    // The last generation spawns nothing and has no buffer below it.
    parameters.children = generation < buffers_.size() ? buffers_[generation].data() : nullptr;
    parameters.child_count = child_count_.data();
    Stream& stream = request_.stream;
    log.time(WorkKind::trace, [&]() -> u64 {
        const u64 rays = slice.ray_count + slice.camera_ray_count;
        child_count_.clear(stream);
        kernel_.launch(Launch::for_items(rays, request_.schedule.block), stream, parameters);
        stream.synchronize();
        return rays;
    });
    log.time(WorkKind::download, [&]() -> u64 {
        child_count_.download(std::span(&waiting_[generation + 1], 1));
        return 0;
    });
}

}  // namespace haste::cuda
