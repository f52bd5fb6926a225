#include "cuda/event.h"
#include "cuda/kernels/replay_params.h"
#include "cuda/renderer_state.h"
#include "host/stopwatch.h"

namespace haste::cuda {

CudaReplayOutput Renderer::replay(const HostScene& host, std::shared_ptr<Scene>& scene,
                                  std::span<const RayQuery<float>> queries, QueryKind kind,
                                  int block) {
    check_block(block);
    check_queries(queries);
    CudaReplayOutput output;
    output.scene_upload_seconds = state_->upload(host, scene);

    ReplaySpecification specification;
    specification.any_hit = kind == QueryKind::any_hit;
    specification.features = host.features();
    const Kernel& kernel = state_->kernels.get(specification);
    output.compile_seconds = kernel.build_seconds();
    output.registers = kernel.attributes().registers;

    const Stopwatch upload;
    const DeviceBuffer<RayQuery<float>> device_queries(queries);
    output.upload_seconds = upload.seconds();
    const DeviceBuffer<QueryHit<float>> device_hits(queries.size());
    ReplayParams parameters;
    parameters.scene = scene->device.view();
    parameters.queries = device_queries.data();
    parameters.hits = device_hits.data();
    parameters.count = queries.size();

    Event start;
    Event end;
    start.record(state_->stream);
    kernel.launch(Launch::for_items(queries.size(), block), state_->stream, parameters);
    end.record(state_->stream);
    output.replay.seconds = seconds_between(start, end);

    output.replay.hits.resize(queries.size());
    const Stopwatch download;
    device_hits.download(output.replay.hits);
    output.download_seconds = download.seconds();
    return output;
}

}  // namespace haste::cuda
