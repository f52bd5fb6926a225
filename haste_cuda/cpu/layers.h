#pragma once

#include "core/engine/layer_plan.h"
#include "cpu/packet.h"

namespace haste {

/// Breadth first, layer by layer (Segovia et al. 2009), as far as the queue's bytes go.
template <class Model, class I, bool Count>
PassResult layers_pass(const PassRequest& request, const Model& model, const I& intersector) {
    const LayerPlan plan = LayerPlan::fit(
        request.tree, request.schedule.queue_bytes / sizeof(Ray<float>), request.schedule.packet);
    const Camera<float>& camera = request.view.camera;
    const SampleRange range = request.range();
    const u64 camera_rays = range.count(camera);
    PacketShader<Model, I, Count> shader(request, model, intersector);
    // generations[g] waits to be traced; generation 0, the camera's, is made slice by slice.
    std::vector<std::vector<Ray<float>>> generations(request.tree.generations + 1);
    std::vector<Ray<float>> slice;
    u64 waiting = 0;
    u64 peak = 0;
    const auto trace = [&](std::size_t generation) {
        shader.shade(slice, [&](std::span<const Ray<float>> children) {
            generations[generation + 1].insert(generations[generation + 1].end(), children.begin(),
                                               children.end());
            waiting += children.size();
        });
        peak = std::max(peak, waiting);
    };
    for (u64 first = 0; first < camera_rays; first += plan.slice) {
        const u64 last = std::min(camera_rays, first + plan.slice);
        slice.clear();
        for (u64 i = first; i < last; ++i) slice.push_back(range.ray(camera, i));
        trace(0);
        std::size_t deepest = 1;
        while (waiting > 0) {
            while (deepest < request.tree.generations && !generations[deepest + 1].empty()) {
                ++deepest;
            }
            while (generations[deepest].empty()) --deepest;
            std::vector<Ray<float>>& layer = generations[deepest];
            const auto begin =
                layer.end() - std::ptrdiff_t(std::min<u64>(plan.slice, layer.size()));
            slice.assign(begin, layer.end());
            layer.erase(begin, layer.end());
            waiting -= slice.size();
            trace(deepest);
        }
    }
    return shader.finish(peak * sizeof(Ray<float>));
}

}  // namespace haste
