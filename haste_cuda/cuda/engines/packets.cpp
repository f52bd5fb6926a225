#include "cuda/engines/packets.h"

#include <algorithm>

namespace haste::cuda {

PacketsEngine::PacketsEngine(const EngineRequest& request)
    : Engine(request), kernel_(kernel("packet")) {
    const u64 rays = request.schedule.packet;
    const u64 children = rays * request.tree.children;
    if (request.schedule.allocation == Allocation::once) {
        buffers_ = std::make_unique<Buffers>(rays, children);
    }
    packet_ = LargeArray<Ray<float>>(rays);
    children_ = LargeArray<Ray<float>>(children);
}

EnginePass PacketsEngine::run(const RenderParams& pass) {
    RayQueue queue(pass.scene.camera, pass.range, request_.tree, request_.schedule);
    prepare(pass.range.count(pass.scene.camera), queue);
    WorkLog log(request_.schedule.record_spans);
    ScheduleWork work;
    const bool per_packet = request_.schedule.allocation == Allocation::per_packet;
    for (;;) {
        const u64 size = log.time(WorkKind::pop, [&] {
            return queue.pop_packet(packet_.front(request_.schedule.packet));
        });
        if (size == 0) break;
        if (per_packet) {
            log.time(WorkKind::allocate, [&]() -> u64 {
                buffers_ = std::make_unique<Buffers>(size, size * request_.tree.children);
                return 0;
            });
        }
        const u64 spawned = trace(pass, packet_.front(size), log);
        if (per_packet) {
            log.time(WorkKind::allocate, [&]() -> u64 {
                buffers_.reset();
                return 0;
            });
        }
        log.time(WorkKind::push, [&] {
            queue.push(children_.front(spawned));
            return spawned;
        });
        ++work.launches;
        work.bytes_moved += (size + spawned) * sizeof(Ray<float>) + sizeof(u32);
    }
    request_.stream.synchronize();
    work.spans = log.take();
    return {log.seconds(), queue.peak_bytes(), std::move(work)};
}

void PacketsEngine::prepare(u64 camera_rays, RayQueue& queue) {
    // Memory that is fresh takes longer to write than a packet to trace, and is no launch's cost.
    const u64 children = request_.tree.children;
    const u64 rays =
        std::min<u64>(request_.schedule.packet, camera_rays * std::max<u64>(children, 1));
    packet_.make_pages(rays);
    children_.make_pages(rays * children);
    queue.reserve(rays * (children + 1));
}

u64 PacketsEngine::trace(const RenderParams& pass, std::span<const Ray<float>> packet,
                         WorkLog& log) {
    Stream& stream = request_.stream;
    Buffers& buffers = *buffers_;
    log.time(WorkKind::upload, [&] {
        buffers.rays.upload(packet);
        return packet.size();
    });
    log.time(WorkKind::trace, [&] {
        buffers.child_count.clear(stream);
        const PacketParams parameters{.render = pass,
                                      .rays = buffers.rays.data(),
                                      .ray_count = u32(packet.size()),
                                      .camera_ray_count = 0,
                                      .first_camera_ray = 0,
                                      .children = buffers.children.data(),
                                      .child_count = buffers.child_count.data()};
        kernel_.launch(Launch::for_items(packet.size(), request_.schedule.block), stream,
                       parameters);
        stream.synchronize();
        return packet.size();
    });
    return log.time(WorkKind::download, [&] {
        u32 spawned = 0;
        buffers.child_count.download(std::span(&spawned, 1));
        buffers.children.download(children_.front(spawned));
        return u64(spawned);
    });
}

}  // namespace haste::cuda
