#pragma once

#include "cuda/device_scene.h"
#include "cuda/kernel.h"
#include "cuda/memory.h"
#include "cuda/render.h"

namespace haste::cuda {

struct Renderer::Scene {
    DeviceScene device;
};

struct Renderer::Rays {
    DeviceBuffer<RayQuery<float>> queries;
};

struct Renderer::State {
    Device device;
    Stream stream;
    KernelSet kernels{device};

    /// The scene and what the traversal reads on the device, uploaded on first use; returns the
    /// seconds that this took.
    double upload(const HostScene& host, std::shared_ptr<Scene>& scene, TraversalKind traversal) {
        device.make_current();
        double seconds = 0;
        if (!scene) {
            scene = std::make_shared<Scene>(DeviceScene(host));
            seconds = scene->device.upload_seconds();
        }
        if (!scene->device.has(traversal)) seconds += scene->device.prepare(host, traversal);
        return seconds;
    }
};

}  // namespace haste::cuda
