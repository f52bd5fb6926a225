#pragma once

#include <vector>

#include "core/engine/layer_plan.h"
#include "cuda/engines/engine.h"
#include "cuda/kernels/packet_params.h"

namespace haste::cuda {

/// Breadth first, layer by layer (Segovia et al. 2009), in device memory: the host learns the size
/// of each layer and launches the next. Layers are cut where the queue's bytes do not hold them.
class LayersEngine : public Engine {
public:
    explicit LayersEngine(const EngineRequest& request);

    EnginePass run(const RenderParams& pass) override;

    const Kernel& main_kernel() const override { return kernel_; }

private:
    /// Traces a slice into the buffer of the generation below it.
    void trace(const PacketParams& slice, std::size_t generation, WorkLog& log);

    const Kernel& kernel_;
    LayerPlan plan_;
    std::vector<DeviceBuffer<Ray<float>>> buffers_;  ///< of generations 1 and up
    DeviceBuffer<u32> child_count_;
    std::vector<u32> waiting_;  ///< rays in each generation's buffer
};

}  // namespace haste::cuda
