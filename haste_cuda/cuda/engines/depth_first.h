#pragma once

#include "cuda/engines/engine.h"

namespace haste::cuda {

/// One thread a sample with a private stack: the mega-kernel.
class DepthFirstEngine : public Engine {
public:
    explicit DepthFirstEngine(const EngineRequest& request)
        : Engine(request), kernel_(kernel("depth_first")) {}

    EnginePass run(const RenderParams& pass) override {
        const Launch shape =
            Launch::for_items(pass.range.count(pass.scene.camera), request_.schedule.block);
        start_.record(request_.stream);
        kernel_.launch(shape, request_.stream, pass);
        end_.record(request_.stream);
        const double seconds = seconds_between(start_, end_);
        return {seconds, 0, one_launch(seconds)};
    }

    const Kernel& main_kernel() const override { return kernel_; }

private:
    const Kernel& kernel_;
    Event start_;
    Event end_;
};

}  // namespace haste::cuda
