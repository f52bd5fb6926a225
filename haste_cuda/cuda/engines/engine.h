#pragma once

#include <memory>

#include "cuda/event.h"
#include "cuda/kernel.h"
#include "cuda/kernels/render_params.h"
#include "cuda/memory.h"
#include "engine/schedule.h"
#include "engine/schedule_work.h"

namespace haste::cuda {

/// What an engine is made from. The device and the kernels outlive it.
struct EngineRequest {
    const Device& device;
    KernelSet& kernels;
    Stream& stream;
    KernelSpecification kernel;
    Schedule schedule;
    RayTree tree;
    u64 most_shadow_rays;  ///< that the shading of one ray can ask for
};

/// What one pass took.
struct EnginePass {
    double seconds = 0;  ///< tracing alone
    u64 peak_queue_bytes = 0;
    ScheduleWork work;
};

/// A way to schedule rays on the GPU. Allocates and compiles in its constructor, so that `run` does
/// nothing but trace. Throws CudaError and CompileError.
class Engine {
public:
    explicit Engine(const EngineRequest& request) : request_(request) {}
    virtual ~Engine() = default;
    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;

    /// Traces all rays of a pass into its film, and waits for them.
    [[nodiscard]] virtual EnginePass run(const RenderParams& pass) = 0;

    /// The kernel that the render's figures (registers, local memory) are of.
    [[nodiscard]] virtual const Kernel& main_kernel() const = 0;

protected:
    /// A kernel for this render's model, precision and features.
    [[nodiscard]] const Kernel& kernel(const std::string& name) const {
        KernelSpecification specification = request_.kernel;
        specification.kernel = name;
        if (name != "depth_first" && name != "persistent") specification.stack_capacity = 1;
        return request_.kernels.get(specification);
    }

    /// Blocks that fill the device.
    [[nodiscard]] std::size_t resident_grid(const Kernel& kernel) const {
        return resident_grid(kernel, request_.schedule.block, 0);
    }
    [[nodiscard]] std::size_t resident_grid(const Kernel& kernel, int block,
                                            std::size_t dynamic_shared_bytes) const {
        const int blocks = kernel.resident_blocks(block, dynamic_shared_bytes);
        // Refused by the launch, with its own message, where no block fits.
        return std::size_t(blocks > 0 ? blocks : 1) *
               std::size_t(request_.device.info().multiprocessors);
    }

    /// What an engine whose pass is one launch did: it traced.
    [[nodiscard]] ScheduleWork one_launch(double seconds, u64 launches = 1) const {
        ScheduleWork work{.launches = launches, .bytes_moved = 0, .spans = {}};
        if (request_.schedule.record_spans) {
            work.spans.push_back({WorkKind::trace, 0, 0, seconds, 0});
        }
        return work;
    }

    EngineRequest request_;
};

/// The engine of the schedule.
[[nodiscard]] std::unique_ptr<Engine> make_engine(const EngineRequest& request);

}  // namespace haste::cuda
