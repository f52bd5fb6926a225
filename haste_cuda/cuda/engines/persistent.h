#pragma once

#include "cuda/engines/engine.h"
#include "cuda/kernels/persistent_params.h"

namespace haste::cuda {

/// As many threads as the device can hold, which fetch work when they fall idle; each warp has a
/// queue in device memory.
class PersistentEngine : public Engine {
public:
    explicit PersistentEngine(const EngineRequest& request);

    EnginePass run(const RenderParams& pass) override;

    const Kernel& main_kernel() const override { return kernel_; }

private:
    const Kernel& kernel_;
    std::size_t blocks_;
    u64 queue_capacity_;
    DeviceBuffer<Ray<float>> queues_;
    DeviceBuffer<u64> next_run_;
    Event start_;
    Event end_;
};

}  // namespace haste::cuda
