#pragma once

#include "cuda/engines/engine.h"
#include "cuda/kernels/packet_params.h"
#include "engine/ray_queue.h"
#include "host/large_array.h"

namespace haste::cuda {

/// The paper's engine: a queue of rays on the host, one packet of it at a time copied to the device
/// from ordinary memory, shaded by one thread a ray, and what it spawned copied back. Device memory
/// is allocated for each packet, as published, or once, the first of the improvements that section
/// 7.1 names.
class PacketsEngine : public Engine {
public:
    explicit PacketsEngine(const EngineRequest& request);

    EnginePass run(const RenderParams& pass) override;

    const Kernel& main_kernel() const override { return kernel_; }

private:
    /// Device memory for one packet.
    struct Buffers {
        explicit Buffers(u64 rays, u64 children) : rays(rays), children(children), child_count(1) {}
        DeviceBuffer<Ray<float>> rays;
        DeviceBuffer<Ray<float>> children;
        DeviceBuffer<u32> child_count;
    };

    /// Makes the host's memory that a render of so many camera rays uses while nothing piles up.
    void prepare(u64 camera_rays, RayQueue& queue);
    /// Traces a packet; its children are in `children_`, as many as it returns.
    u64 trace(const RenderParams& pass, std::span<const Ray<float>> packet, WorkLog& log);

    const Kernel& kernel_;
    std::unique_ptr<Buffers> buffers_;
    LargeArray<Ray<float>> packet_;
    LargeArray<Ray<float>> children_;
};

}  // namespace haste::cuda
