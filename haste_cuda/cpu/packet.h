#pragma once

#include <atomic>
#include <span>

#include "cpu/depth_first.h"

namespace haste {

/// What the rays of a piece of a packet spawn.
struct SpawnedRays {
    std::vector<Ray<float>>& rays;
    bool weighted;  ///< layers are weighted afterwards

    void push(const Ray<float>& ray) const {
        rays.push_back(ray);
        if (weighted) drop_contribution(rays.back());
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
        result_.launches = 0;
    }

    /// Traces and shades a packet; calls `push(children)` with pieces of what it spawned, in an
    /// order that depends on the packet alone.
    template <class Push>
    void shade(std::span<const Ray<float>> packet, Push&& push) {
        // Chunks are cut by position, not by worker, so the children's order is the same at any
        // number of threads.
        constexpr std::size_t rays_per_chunk = 64;
        const std::size_t chunks = (packet.size() + rays_per_chunk - 1) / rays_per_chunk;
        ++result_.launches;
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
        const SpawnedRays spawned{children, weighted()};
        for (const Ray<float>& ray : rays) {
            FilmSum sum;
            TraceOut<Count, float, I, FilmSum, SpawnedRays> out{intersector_, request_.format, sum,
                                                                tally.rays, spawned};
            out.trace(model_, ray);
            add_to_film(ray, sum);
            tally.add_faults(sum, ray.pixel);
        }
    }

    [[nodiscard]] bool weighted() const { return request_.film_layers > 1; }

    /// Adds what a ray brought to the film, which all workers share.
    void add_to_film(const Ray<float>& ray, FilmSum& sum) {
        const Camera<float>& camera = request_.view.camera;
        const std::size_t layer = weighted() ? ray.layer : 0;
        const std::size_t place = layer * camera.width * camera.height + ray.pixel;
        for (std::size_t c = 0; c < 3; ++c) {
            if (sum.channel[c] == 0) continue;
            std::atomic_ref<i64> target(result_.film.sums[3 * place + c]);
            i64 before = target.load(std::memory_order_relaxed);
            do {
                if (before > FilmSum::max_sum - sum.channel[c]) {
                    sum.overflow = true;
                    break;
                }
            } while (!target.compare_exchange_weak(before, before + sum.channel[c],
                                                   std::memory_order_relaxed));
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
