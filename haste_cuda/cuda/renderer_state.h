#pragma once

#include "cuda/device_scene.h"
#include "cuda/kernel.h"
#include "cuda/render.h"

namespace haste::cuda {

struct Renderer::Scene {
    DeviceScene device;
};

struct Renderer::State {
    Device device;
    Stream stream;
    KernelSet kernels{device};

    /// The scene on the device, uploaded on first use; returns the seconds that this took.
    double upload(const HostScene& host, std::shared_ptr<Scene>& scene) {
        device.make_current();
        if (scene) return 0;
        scene = std::make_shared<Scene>(DeviceScene(host));
        return scene->device.upload_seconds();
    }
};

}  // namespace haste::cuda
