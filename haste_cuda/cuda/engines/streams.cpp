#include "cuda/engines/streams.h"

#include <algorithm>
#include <thread>

#include "host/stopwatch.h"

namespace haste::cuda {

namespace {

/// A packet is as large as the setting says and as leaves room for what one sample needs and for
/// the children of all streams.
u64 chunk_rays(const EngineRequest& request) {
    const u64 chunks =
        request.tree.lifo_need() + u64(request.schedule.streams + 1) * request.tree.children;
    const u64 room = request.schedule.queue_bytes / sizeof(Ray<float>) / chunks;
    return std::clamp<u64>(room, 1, request.schedule.packet);
}

}  // namespace

StreamsEngine::StreamsEngine(const EngineRequest& request)
    : Engine(request),
      kernel_(kernel("packet")),
      chunk_rays_(chunk_rays(request)),
      admission_(request.tree, request.schedule.queue_bytes / sizeof(Ray<float>) / chunk_rays_, 1),
      events_(request.schedule.record_spans) {
    for (u32 i = 0; i < request.schedule.streams; ++i) {
        lanes_.emplace_back(chunk_rays_, chunk_rays_ * request.tree.children).number = i;
    }
    // What is in use while nothing piles up; page-locking takes time that is not tracing's.
    const u64 usual = u64(request.schedule.streams) * (request.tree.children + 1);
    while (free_.size() < usual) free_.push_back({PinnedBuffer<Ray<float>>(chunk_rays_), 0});
}

EnginePass StreamsEngine::run(const RenderParams& pass) {
    const Stopwatch watch;
    camera_rays_ = pass.range.count(pass.scene.camera);
    next_camera_ray_ = 0;
    peak_rays_ = 0;
    work_ = {};
    events_.start(lanes_.front().stream);
    for (;;) {
        bool moved = false;
        for (Lane& lane : lanes_) {
            moved |= lane.state == Lane::State::idle ? launch(pass, lane) : advance(lane);
        }
        if (moved) continue;
        if (under_way_ == 0) break;
        std::this_thread::yield();
    }
    const double seconds = watch.seconds();
    work_.spans = events_.spans();
    return {seconds, peak_rays_ * sizeof(Ray<float>), std::move(work_)};
}

bool StreamsEngine::launch(const RenderParams& pass, Lane& lane) {
    const u64 unborn = camera_rays_ - next_camera_ray_;
    if (waiting_.empty() && unborn == 0) return false;
    const u64 children = request_.tree.children;
    const u64 set_aside = waiting_.size() + under_way_ * children;
    const bool admitted = set_aside + children - (waiting_.empty() ? 0 : 1) <= admission_.mark();
    if (!admitted && under_way_ > 0) return false;

    PacketParams parameters{};
    parameters.render = pass;
    if (!waiting_.empty()) {
        const bool newest = !admitted || request_.schedule.order == QueueOrder::lifo;
        std::swap(lane.source, newest ? waiting_.back() : waiting_.front());
        newest ? waiting_.pop_back() : waiting_.pop_front();
        parameters.ray_count = lane.source.size;
        waiting_rays_ -= lane.source.size;
        events_.time(WorkKind::upload, lane.number, lane.source.size, lane.stream, [&] {
            lane.rays.upload(lane.source.rays.front(lane.source.size), lane.stream);
        });
    }
    if (admitted || parameters.ray_count == 0) {
        parameters.camera_ray_count = u32(std::min(chunk_rays_ - parameters.ray_count, unborn));
        parameters.first_camera_ray = next_camera_ray_;
        next_camera_ray_ += parameters.camera_ray_count;
    }
    parameters.rays = lane.rays.data();
    parameters.children = lane.children.data();
    parameters.child_count = lane.child_count.data();
    lane.child_count.clear(lane.stream);
    const u64 rays = parameters.ray_count + parameters.camera_ray_count;
    events_.time(WorkKind::trace, lane.number, rays, lane.stream, [&] {
        kernel_.launch(Launch::for_items(rays, request_.schedule.block), lane.stream, parameters);
    });
    lane.child_count.download(lane.seen_count.front(1), lane.stream);
    lane.state = Lane::State::tracing;
    ++work_.launches;
    work_.bytes_moved += parameters.ray_count * sizeof(Ray<float>) + sizeof(u32);
    ++under_way_;
    return true;
}

bool StreamsEngine::advance(Lane& lane) {
    if (!lane.stream.finished()) return false;
    if (lane.state == Lane::State::tracing) {
        if (lane.source.rays.size() > 0) free_.push_back(std::exchange(lane.source, {}));
        start_download(lane);
        return true;
    }
    for (Chunk& chunk : lane.landing) {
        waiting_rays_ += chunk.size;
        waiting_.push_back(std::move(chunk));
    }
    lane.landing.clear();
    peak_rays_ = std::max(peak_rays_, waiting_rays_);
    --under_way_;
    lane.state = Lane::State::idle;
    return true;
}

void StreamsEngine::start_download(Lane& lane) {
    const u64 spawned = *lane.seen_count.data();
    for (u64 first = 0; first < spawned; first += chunk_rays_) {
        Chunk chunk = take_chunk();
        chunk.size = u32(std::min(chunk_rays_, spawned - first));
        events_.time(WorkKind::download, lane.number, chunk.size, lane.stream, [&] {
            lane.children.download(chunk.rays.front(chunk.size), lane.stream, first);
        });
        lane.landing.push_back(std::move(chunk));
    }
    work_.bytes_moved += spawned * sizeof(Ray<float>);
    lane.state = Lane::State::downloading;
}

StreamsEngine::Chunk StreamsEngine::take_chunk() {
    if (free_.empty()) return {PinnedBuffer<Ray<float>>(chunk_rays_), 0};
    Chunk chunk = std::move(free_.back());
    free_.pop_back();
    return chunk;
}

}  // namespace haste::cuda
