#pragma once

#include <deque>
#include <list>
#include <vector>

#include "core/engine/admission.h"
#include "cuda/engines/engine.h"
#include "cuda/kernels/packet_params.h"
#include "cuda/work_events.h"

namespace haste::cuda {

/// The improvement that the paper's section 7.1 ends with: streams, so that rays go up, are traced
/// and come down at once. The queue on the host is made of chunks of page-locked memory. What a
/// packet spawned comes down into chunks, and each of them goes up again as the next packet, as it
/// is. Camera rays are made on the device.
///
/// `Admission` counts chunks here. Packets under way have room for all their children set aside;
/// where the next has not, those under way land first, and then one packet runs at a time.
class StreamsEngine : public Engine {
public:
    explicit StreamsEngine(const EngineRequest& request);

    EnginePass run(const RenderParams& pass) override;

    const Kernel& main_kernel() const override { return kernel_; }

private:
    /// Rays that wait on the host.
    struct Chunk {
        PinnedBuffer<Ray<float>> rays;
        u32 size = 0;
    };

    /// A stream with room for one packet.
    struct Lane {
        enum class State { idle, tracing, downloading };

        Lane(u64 packet, u64 children) : rays(packet), children(children), child_count(1) {}

        State state = State::idle;
        u32 number = 0;
        Stream stream;
        DeviceBuffer<Ray<float>> rays;
        DeviceBuffer<Ray<float>> children;
        DeviceBuffer<u32> child_count;
        PinnedBuffer<u32> seen_count{1};
        Chunk source;                ///< on its way up
        std::vector<Chunk> landing;  ///< on their way down
    };

    /// Starts the next packet on an idle lane, if there is one and it is admitted.
    bool launch(const RenderParams& pass, Lane& lane);
    /// Moves a busy lane on if its stream has come to the end of what it was given.
    bool advance(Lane& lane);
    void start_download(Lane& lane);

    [[nodiscard]] Chunk take_chunk();

    const Kernel& kernel_;
    u64 chunk_rays_;
    Admission admission_;
    std::list<Lane> lanes_;
    std::deque<Chunk> waiting_;
    std::vector<Chunk> free_;
    u64 under_way_ = 0;
    u64 camera_rays_ = 0;
    u64 next_camera_ray_ = 0;
    u64 waiting_rays_ = 0;
    u64 peak_rays_ = 0;
    WorkEvents events_;
    ScheduleWork work_;
};

}  // namespace haste::cuda
