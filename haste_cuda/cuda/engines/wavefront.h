#pragma once

#include "cuda/engines/engine.h"
#include "cuda/kernels/wavefront_params.h"

namespace haste::cuda {

/// The queue in device memory, and a kernel for each step of a packet: plan, generate, closest hit,
/// shade, close the gap, any hit. Kernels read how much there is to do from the device's own
/// counters, so the host puts steps into the stream without knowing any count; one flag, read
/// behind the work, tells it when to stop.
class WavefrontEngine : public Engine {
public:
    explicit WavefrontEngine(const EngineRequest& request);

    EnginePass run(const RenderParams& pass) override;

    const Kernel& main_kernel() const override { return closest_hit_; }

private:
    /// How the schedule's bytes are shared out.
    struct Room {
        u64 packet;  ///< rays traced at once: as many as half of the bytes are enough for
        u64 queue;   ///< rays that may wait

        explicit Room(const EngineRequest& request);
    };

    /// A kernel and a launch that fills the device with it.
    struct Step {
        const Kernel& kernel;
        Launch shape;
    };

    /// A step whose kernel only traces, by warps that stay if the traversal has such.
    [[nodiscard]] Step tracing_step(const std::string& name) const;
    [[nodiscard]] Step step(const std::string& name) const;

    void launch_packet(const WavefrontParams& parameters);

    const Kernel& plan_;
    const Kernel& closest_hit_;
    std::vector<Step> steps_;
    Room room_;
    DeviceBuffer<Ray<float>> queue_;
    DeviceBuffer<Hit<float>> hits_;
    DeviceBuffer<ShadowList::Way> shadow_ways_;
    DeviceBuffer<ShadowList::Light> shadow_lights_;
    DeviceBuffer<u32> shadow_roundings_;
    DeviceBuffer<WavefrontState> state_;
    PinnedBuffer<WavefrontState> seen_;  ///< one behind each group of packets under way
    Event start_;
    Event end_;
    Event group_done_[2];
};

}  // namespace haste::cuda
