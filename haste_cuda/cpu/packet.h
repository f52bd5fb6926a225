#pragma once

#include <atomic>
#include <span>

#include "cpu/depth_first.h"

namespace haste {

/// Receives what a model sends out while a packet is shaded: light goes to the shared film in
/// atomic integer adds, children into the worker's part of the output.
template <class I, bool Count>
struct PacketOut {
    const I& intersector;
    const PassRequest& request;
    std::vector<i64>& sums;
    WorkerTally& tally;
    std::vector<Ray<float>>& children;
    u32 layer = 0;  ///< of the film that light goes to

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
        const Camera<float>& camera = request.view.camera;
        const std::size_t at =
            3 * (std::size_t(layer) * camera.width * camera.height + std::size_t(pixel));
        FilmSum sum;
        sum.add(request.format, value, rounding);
        for (int c = 0; c < 3; ++c) {
            if (sum.channel[c] == 0) continue;
            std::atomic_ref<i64> target(sums[at + std::size_t(c)]);
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

/// Shades packets on a thread pool and hands on what they spawn: what the engines with a queue
/// share.
template <class Model, class I, bool Count>
class PacketShader {
public:
    PacketShader(const PassRequest& request, const Model& model, const I& intersector)
        : request_(request), model_(model), intersector_(intersector) {
        result_.film.sums.assign(request.film_size(), 0);
    }

    /// Traces and shades a packet; calls `push(children)` with pieces of what it spawned, in an
    /// order that depends on the packet alone.
    template <class Push>
    void shade(std::span<const Ray<float>> packet, Push&& push) {
        // Chunks are cut by position, not by worker, so the children's order is the same at any
        // number of threads.
        constexpr std::size_t rays_per_chunk = 64;
        const std::size_t chunks = (packet.size() + rays_per_chunk - 1) / rays_per_chunk;
        if (children_.size() < chunks) children_.resize(chunks);
        const auto shade_chunk = [&](std::size_t chunk) {
            const std::size_t begin = chunk * rays_per_chunk;
            shade_rays(packet.subspan(begin, std::min(rays_per_chunk, packet.size() - begin)),
                       children_[chunk]);
        };
        if (chunks == 1) {
            shade_chunk(0);
        } else {
            tbb::parallel_for(std::size_t(0), chunks, shade_chunk);
        }
        for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
            push(std::span<const Ray<float>>(children_[chunk]));
        }
    }

    PassResult finish(u64 peak_queue_bytes) {
        result_.peak_queue_bytes = peak_queue_bytes;
        for (const WorkerTally& tally : tallies_) tally.fold_into(result_);
        return std::move(result_);
    }

private:
    void shade_rays(std::span<const Ray<float>> rays, std::vector<Ray<float>>& children) {
        WorkerTally& tally = tallies_.local();
        children.clear();
        PacketOut<I, Count> out{intersector_, request_, result_.film.sums, tally, children};
        const bool weighted = request_.film_layers > 1;
        for (const Ray<float>& ray : rays) {
            if constexpr (Count) tally.rays.count(ray);
            if (!weighted) {
                trace_and_shade(model_, intersector_, ray, out);
                continue;
            }
            out.layer = ray.layer;
            const std::size_t first_child = children.size();
            trace_and_shade(model_, intersector_, ray, out);
            for (std::size_t i = first_child; i < children.size(); ++i) {
                drop_contribution(children[i]);
            }
        }
    }

    const PassRequest& request_;
    const Model& model_;
    const I& intersector_;
    PassResult result_;
    tbb::enumerable_thread_specific<WorkerTally> tallies_;
    std::vector<std::vector<Ray<float>>> children_;
};

}  // namespace haste
