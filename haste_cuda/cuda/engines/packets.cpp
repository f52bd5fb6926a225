#include "cuda/engines/packets.h"

#include "engine/ray_queue.h"
#include "host/stopwatch.h"

namespace haste::cuda {

PacketsEngine::PacketsEngine(const EngineRequest& request)
    : Engine(request), kernel_(kernel("packet")) {
    const u64 rays = request.schedule.packet;
    const u64 children = rays * request.tree.children;
    if (request.schedule.allocation == Allocation::once) {
        kept_ = std::make_unique<Buffers>(rays, children);
    }
    packet_ = std::make_unique_for_overwrite<Ray<float>[]>(rays);
    children_ = std::make_unique_for_overwrite<Ray<float>[]>(children);
}

EnginePass PacketsEngine::run(const RenderParams& pass) {
    const Stopwatch watch;
    RayQueue queue(pass.scene.camera, pass.range, request_.tree, request_.schedule);
    for (;;) {
        const u64 size = queue.pop_packet({packet_.get(), request_.schedule.packet});
        if (size == 0) break;
        const std::span<const Ray<float>> packet(packet_.get(), size);
        u64 spawned = 0;
        if (kept_) {
            spawned = trace(pass, packet, *kept_);
        } else {
            Buffers buffers(size, size * request_.tree.children);
            spawned = trace(pass, packet, buffers);
        }
        queue.push({children_.get(), spawned});
    }
    request_.stream.synchronize();
    return {watch.seconds(), queue.peak_bytes()};
}

u64 PacketsEngine::trace(const RenderParams& pass, std::span<const Ray<float>> packet,
                         Buffers& buffers) {
    Stream& stream = request_.stream;
    buffers.rays.upload(packet);
    buffers.child_count.clear(stream);
    const PacketParams parameters{.render = pass,
                                  .rays = buffers.rays.data(),
                                  .ray_count = u32(packet.size()),
                                  .camera_ray_count = 0,
                                  .first_camera_ray = 0,
                                  .children = buffers.children.data(),
                                  .child_count = buffers.child_count.data()};
    kernel_.launch(Launch::for_items(packet.size(), request_.schedule.block), stream, parameters);
    stream.synchronize();
    u32 spawned = 0;
    buffers.child_count.download(std::span(&spawned, 1));
    buffers.children.download(std::span(children_.get(), spawned));
    return spawned;
}

}  // namespace haste::cuda
