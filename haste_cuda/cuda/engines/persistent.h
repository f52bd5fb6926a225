#pragma once

#include "cuda/engines/engine.h"
#include "cuda/kernels/persistent_params.h"

namespace haste::cuda {

/// As many threads as the device can hold, each with a private stack, which begin a sample when
/// they fall idle.
class PersistentEngine : public Engine {
public:
    explicit PersistentEngine(const EngineRequest& request);

    EnginePass run(const RenderParams& pass) override;

    const Kernel& main_kernel() const override { return kernel_; }

private:
    const Kernel& kernel_;
    std::size_t blocks_;
    DeviceBuffer<u64> next_run_;
    Event start_;
    Event end_;
};

}  // namespace haste::cuda
