#pragma once

#include "cuda/engines/engine.h"
#include "cuda/kernels/wavefront_params.h"

namespace haste::cuda {

/// The queue in device memory, and a kernel for each step of a packet: plan, generate, closest hit,
/// shade, any hit. Kernels read how much there is to do from the device's own counters, so the host
/// puts steps into the stream without knowing any count; one flag, read behind the work, tells it
/// when to stop.
class WavefrontEngine : public Engine {
public:
    explicit WavefrontEngine(const EngineRequest& request);

    EnginePass run(const RenderParams& pass) override;

    const Kernel& main_kernel() const override { return closest_hit_; }

private:
    /// A kernel and the blocks that fill the device with it.
    struct Step {
        const Kernel& kernel;
        std::size_t blocks;
    };

    void launch_packet(const WavefrontParams& parameters);

    const Kernel& plan_;
    const Kernel& closest_hit_;
    std::vector<Step> steps_;
    u64 capacity_;
    DeviceBuffer<Ray<float>> queue_;
    DeviceBuffer<Ray<float>> packet_;
    DeviceBuffer<Hit<float>> hits_;
    DeviceBuffer<ShadowRay<float>> shadows_;
    DeviceBuffer<WavefrontState> state_;
    PinnedBuffer<WavefrontState> seen_;  ///< one behind each group of packets under way
    Event start_;
    Event end_;
    Event group_done_[2];
};

}  // namespace haste::cuda
