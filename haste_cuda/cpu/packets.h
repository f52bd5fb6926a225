#pragma once

#include <atomic>
#include <deque>

#include "cpu/depth_first.h"

namespace haste {

/// The paper's queue of pending rays, section 4.2, topped up with camera rays: all rays are treated
/// the same, whatever they are for.
class RayQueue {
public:
    RayQueue(const Camera<float>& camera, u32 seed, u32 first_sample, u32 samples, QueueOrder order)
        : camera_(camera),
          seed_(seed),
          first_sample_(first_sample),
          pixels_(u64(camera.width) * camera.height),
          camera_rays_(pixels_ * samples),
          order_(order) {}

    /// Takes up to `size` rays: pending ones by the queue's order, then camera rays not yet born.
    void pop_packet(u64 size, std::vector<Ray<float>>& packet) {
        packet.clear();
        const u64 pending = std::min<u64>(size, rays_.size());
        if (order_ == QueueOrder::fifo) {
            const auto end = rays_.begin() + std::ptrdiff_t(pending);
            packet.assign(rays_.begin(), end);
            rays_.erase(rays_.begin(), end);
        } else {
            const auto begin = rays_.end() - std::ptrdiff_t(pending);
            packet.assign(begin, rays_.end());
            rays_.erase(begin, rays_.end());
        }
        while (packet.size() < size && next_camera_ray_ < camera_rays_) {
            packet.push_back(camera_ray(camera_, u32(next_camera_ray_ % pixels_),
                                        first_sample_ + u32(next_camera_ray_ / pixels_), seed_));
            ++next_camera_ray_;
        }
    }

    void push(const std::vector<Ray<float>>& rays) {
        rays_.insert(rays_.end(), rays.begin(), rays.end());
        peak_ = std::max<u64>(peak_, rays_.size());
    }

    [[nodiscard]] u64 peak_bytes() const { return peak_ * sizeof(Ray<float>); }

private:
    Camera<float> camera_;
    u32 seed_;
    u32 first_sample_;
    u64 pixels_;
    u64 camera_rays_;
    QueueOrder order_;
    std::deque<Ray<float>> rays_;
    u64 next_camera_ray_ = 0;
    u64 peak_ = 0;
};

/// Receives what a model sends out while a packet is shaded: light goes to the shared film in
/// atomic integer adds, children into the worker's part of the output.
template <class I, bool Count>
struct PacketOut {
    const I& intersector;
    const FixedPoint& format;
    std::vector<i64>& sums;
    WorkerTally& tally;
    std::vector<Ray<float>>& children;

    void radiance(const Ray<float>& ray, const Vec3f& value, u32 rounding) {
        add(ray.pixel, value, rounding);
    }

    void shadow(const ShadowRay<float>& ray) {
        if constexpr (Count) ++tally.rays.shadow;
        if (!intersector.occluded(ray)) add(ray.pixel, ray.value, ray.rounding);
    }

    void child(const Ray<float>& ray) { children.push_back(ray); }

private:
    void add(u32 pixel, const Vec3f& value, u32 rounding) {
        FilmSum sum;
        sum.add(format, value, rounding);
        for (int c = 0; c < 3; ++c) {
            if (sum.channel[c] == 0) continue;
            std::atomic_ref<i64> target(sums[3 * std::size_t(pixel) + c]);
            i64 before = target.load(std::memory_order_relaxed);
            do {
                if (before > FilmSum::max_sum - sum.channel[c]) {
                    sum.overflow = true;
                    break;
                }
            } while (!target.compare_exchange_weak(before, before + sum.channel[c],
                                                   std::memory_order_relaxed));
        }
        tally.add_faults(sum, pixel);
    }
};

/// The paper's scheme on a thread pool: take a packet of P rays from the queue, shade them one ray
/// a thread, push what they spawn, until the queue is dry.
template <class Model, class I, bool Count>
PassResult packets_pass(const PassRequest& request, const Model& model, const I& intersector) {
    const Camera<float>& camera = request.view.camera;
    PassResult result;
    result.film.sums.assign(3 * std::size_t(camera.width) * camera.height, 0);
    tbb::enumerable_thread_specific<WorkerTally> tallies;
    RayQueue queue(camera, request.settings.seed, request.first_sample, request.samples,
                   request.schedule.order);
    // Chunks are cut by position, not by worker, so the queue's order is the same at any number of
    // threads.
    constexpr std::size_t rays_per_chunk = 64;
    std::vector<Ray<float>> packet;
    std::vector<std::vector<Ray<float>>> children;
    const auto shade_chunk = [&](std::size_t chunk) {
        WorkerTally& tally = tallies.local();
        children[chunk].clear();
        PacketOut<I, Count> out{intersector, request.format, result.film.sums, tally,
                                children[chunk]};
        const std::size_t end = std::min(packet.size(), (chunk + 1) * rays_per_chunk);
        for (std::size_t i = chunk * rays_per_chunk; i < end; ++i) {
            if constexpr (Count) tally.rays.count(packet[i]);
            trace_and_shade(model, intersector, packet[i], out);
        }
    };
    for (;;) {
        queue.pop_packet(request.schedule.packet, packet);
        if (packet.empty()) break;
        const std::size_t chunks = (packet.size() + rays_per_chunk - 1) / rays_per_chunk;
        if (children.size() < chunks) children.resize(chunks);
        if (chunks == 1) {
            shade_chunk(0);
        } else {
            tbb::parallel_for(std::size_t(0), chunks, shade_chunk);
        }
        for (std::size_t chunk = 0; chunk < chunks; ++chunk) queue.push(children[chunk]);
    }
    result.peak_queue_bytes = queue.peak_bytes();
    for (const WorkerTally& tally : tallies) tally.fold_into(result);
    return result;
}

}  // namespace haste
