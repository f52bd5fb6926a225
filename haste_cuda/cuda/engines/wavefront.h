#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cuda/engines/engine.h"
#include "cuda/engines/wavefront_room.h"
#include "cuda/kernels/wavefront_params.h"

namespace haste::cuda {

/// The queue in device memory, and a kernel for each step of a packet: plan, generate, closest hit,
/// shade, any hit. Kernels read how much there is to do from the device's own
/// counters, so the host puts steps into a stream without knowing any count; one flag, read behind
/// the work, tells it when to stop.
///
/// A step ends with the longest of its rays, and the next begins with an idle device. So the
/// samples are shared out among lanes, each with a queue and a stream of its own: while one waits
/// for its last rays, the steps of another fill the device.
class WavefrontEngine : public Engine {
public:
    explicit WavefrontEngine(const EngineRequest& request);

    EnginePass run(const RenderParams& pass) override;

    const Kernel& main_kernel() const override { return closest_hit_; }

private:
    /// A queue over a part of the samples, and the stream in which its packets are worked on.
    struct Lane {
        Lane(const WavefrontRoom& room, u64 most_shadow_rays);

        /// Clears the queue and gives the lane the camera rays from `first` up to `end`.
        void start(const RenderParams& pass, const Admission& admission, u64 first, u64 end);

        Stream stream;
        DeviceBuffer<Ray<float>> queue;
        DeviceBuffer<Hit<float>> hits;
        DeviceBuffer<ShadowList::Way> shadow_ways;
        DeviceBuffer<ShadowList::Light> shadow_lights;
        DeviceBuffer<u32> shadow_roundings;
        DeviceBuffer<WavefrontState> state;
        PinnedBuffer<WavefrontState> seen;  ///< after each of two packets, one behind the other
        Event looked[2];                    ///< behind them
        std::optional<WavefrontParams> parameters;
        u64 launched = 0;
        bool done = false;
    };

    /// A kernel and a launch that fills the device with it.
    struct Step {
        const Kernel& kernel;
        Launch shape;
    };

    /// A step whose kernel only traces, by warps that stay if the traversal has such.
    [[nodiscard]] Step tracing_step(const std::string& name) const;
    [[nodiscard]] Step step(const std::string& name) const;

    /// Puts a packet behind the one under way, and waits for that.
    void advance(Lane& lane) const;

    const Kernel& plan_;
    const Kernel& closest_hit_;
    std::vector<Step> steps_;
    WavefrontRoom room_;
    std::vector<Lane> lanes_;
    Event start_;
};

}  // namespace haste::cuda
