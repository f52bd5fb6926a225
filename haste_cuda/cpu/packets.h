#pragma once

#include "cpu/packet.h"
#include "engine/ray_queue.h"

namespace haste {

/// The paper's scheme on a thread pool: take a packet of P rays from the queue, shade them one ray
/// a thread, push what they spawn, until the queue is dry.
template <class Model, class I, bool Count>
PassResult packets_pass(const PassRequest& request, const Model& model, const I& intersector) {
    RayQueue queue(request.view.camera, request.range(), request.tree, request.schedule);
    PacketShader<Model, I, Count> shader(request, model, intersector);
    const LargeArray<Ray<float>> packet(request.schedule.packet);
    for (;;) {
        const u64 size = queue.pop_packet(packet.front(request.schedule.packet));
        if (size == 0) break;
        shader.shade(packet.front(size),
                     [&](std::span<const Ray<float>> children) { queue.push(children); });
    }
    return shader.finish(queue.peak_bytes());
}

}  // namespace haste
