#include <algorithm>
#include <stdexcept>

#include "core/accel/traversal.h"
#include "cuda/event.h"
#include "cuda/kernels/replay_params.h"
#include "cuda/kernels/resident_params.h"
#include "cuda/renderer_state.h"
#include "host/stopwatch.h"

namespace haste::cuda {

namespace {

/// One kind of replay on the device: its kernel and how it is launched.
class Replay {
public:
    Replay(const Kernel& kernel, bool resident, int block, int multiprocessors,
           const ReplayParams& parameters)
        : kernel_(kernel), parameters_(parameters), next_(1) {
        parameters_.next = next_.data();
        shape_ = Launch::for_items(parameters.count, block);
        if (!resident) return;
        shape_.dynamic_shared_bytes = std::size_t(block) * shared_stack_entries * sizeof(Bvh8Group);
        const auto fitting = std::size_t(
            multiprocessors * kernel.resident_blocks(block, shape_.dynamic_shared_bytes));
        shape_.blocks = std::min(shape_.blocks, fitting);
    }

    /// Seconds of the kernel alone, by the device's clock.
    double run(Stream& stream) {
        next_.clear(stream);
        start_.record(stream);
        kernel_.launch(shape_, stream, parameters_);
        end_.record(stream);
        return seconds_between(start_, end_);
    }

private:
    const Kernel& kernel_;
    ReplayParams parameters_;
    DeviceBuffer<u32> next_;
    Launch shape_;
    Event start_;
    Event end_;
};

}  // namespace

CudaReplayOutput Renderer::replay(const HostScene& host, std::shared_ptr<Scene>& scene,
                                  const RayBatch& rays, std::shared_ptr<Rays>& device_rays,
                                  QueryKind kind, const CudaReplaySchedule& schedule) {
    check_block(schedule.block);
    if (schedule.traversal == TraversalKind::bvh8 && schedule.block > max_resident_block) {
        throw std::invalid_argument(
            "block must be at most 512 with bvh8, whose stacks lie in shared memory, not " +
            std::to_string(schedule.block));
    }
    check_repeats(schedule.repeats);
    check_replay_precision(schedule.precision);
    // The counter of rays may run ahead by a warp a warp.
    if (rays.size() > 0xf0000000u) throw std::invalid_argument("too many rays for one replay");
    CudaReplayOutput output;
    output.scene_upload_seconds = state_->upload(host, scene, schedule.traversal);

    ReplaySpecification specification;
    specification.any_hit = kind == QueryKind::any_hit;
    specification.traversal = name_of(schedule.traversal);
    specification.precision = name_of(schedule.precision);
    specification.features = host.features();
    const Kernel& kernel = state_->kernels.get(specification);
    output.compile_seconds = kernel.build_seconds();
    output.registers = kernel.attributes().registers;

    if (!device_rays) {
        const Stopwatch upload;
        device_rays = std::make_shared<Rays>(DeviceBuffer<RayQuery<float>>(rays.queries()));
        output.upload_seconds = upload.seconds();
    }
    const DeviceBuffer<QueryHit<float>> device_hits(rays.size());
    ReplayParams parameters{};
    parameters.scene = scene->device.view();
    parameters.queries = device_rays->queries.data();
    parameters.hits = device_hits.data();
    parameters.count = u32(rays.size());

    const int multiprocessors = state_->device.info().multiprocessors;
    Replay replay(kernel, specification.resident(), schedule.block, multiprocessors, parameters);
    for (int i = 0; i < schedule.repeats; ++i) {
        output.replay.seconds.push_back(replay.run(state_->stream));
    }
    if (schedule.hits) {
        output.replay.hits.resize(rays.size());
        const Stopwatch download;
        device_hits.download(output.replay.hits);
        output.download_seconds = download.seconds();
    }
    if (schedule.count) {
        specification.count = true;
        DeviceBuffer<Tally> visited(1);
        visited.clear(state_->stream);
        parameters.visited = visited.data();
        Replay(state_->kernels.get(specification), specification.resident(), schedule.block,
               multiprocessors, parameters)
            .run(state_->stream);
        output.replay.visited = visited.download().front();
    }
    return output;
}

}  // namespace haste::cuda
