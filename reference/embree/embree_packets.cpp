#include "reference/embree/embree_packets.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>

#include "cpu/replay.h"

namespace haste {

namespace {

template <int Width>
struct Packet;

template <>
struct Packet<8> {
    using Ray = RTCRay8;
    using RayHit = RTCRayHit8;
};

template <>
struct Packet<16> {
    using Ray = RTCRay16;
    using RayHit = RTCRayHit16;
};

/// Fills the lanes of a packet, and says which of them hold a ray.
template <int Width>
void fill(std::span<const RayQuery<float>> queries, typename Packet<Width>::Ray& rays, int* valid) {
    for (int lane = 0; lane < Width; ++lane) {
        const bool used = std::size_t(lane) < queries.size();
        const RayQuery<float>& query = queries[used ? std::size_t(lane) : 0];
        valid[lane] = used ? -1 : 0;
        rays.org_x[lane] = query.origin.x;
        rays.org_y[lane] = query.origin.y;
        rays.org_z[lane] = query.origin.z;
        rays.dir_x[lane] = query.direction.x;
        rays.dir_y[lane] = query.direction.y;
        rays.dir_z[lane] = query.direction.z;
        rays.tnear[lane] = query.t_min;
        rays.tfar[lane] = query.t_max;
        rays.time[lane] = 0.0f;
        rays.mask[lane] = 0xffffffffu;
        rays.id[lane] = u32(lane);
        rays.flags[lane] = 0;
    }
}

template <int Width>
void trace_closest(const EmbreeScene& scene, std::span<const RayQuery<float>> queries,
                   QueryHit<float>* hits) {
    OwnerContext context;
    init_context(context, no_shape);
    alignas(64) int valid[Width];
    typename Packet<Width>::RayHit packet;
    fill<Width>(queries, packet.ray, valid);
    for (int lane = 0; lane < Width; ++lane) {
        packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
    embree_intersect(valid, scene.handle(), context, packet);
    for (std::size_t lane = 0; lane < queries.size(); ++lane) {
        const u32 geometry = packet.hit.geomID[lane];
        if (geometry == RTC_INVALID_GEOMETRY_ID) {
            hits[lane] = {Numeric<float>::infinity, no_primitive};
        } else {
            hits[lane] = {packet.ray.tfar[lane],
                          scene.primitive(geometry, packet.hit.primID[lane])};
        }
    }
}

template <int Width>
void trace_any(const EmbreeScene& scene, std::span<const RayQuery<float>> queries,
               QueryHit<float>* hits) {
    OwnerContext context;
    init_context(context, no_shape);
    alignas(64) int valid[Width];
    typename Packet<Width>::Ray packet;
    fill<Width>(queries, packet, valid);
    embree_occluded(valid, scene.handle(), context, packet);
    for (std::size_t lane = 0; lane < queries.size(); ++lane) {
        const bool found = packet.tfar[lane] < 0.0f;
        hits[lane] = {found ? 0.0f : Numeric<float>::infinity, no_primitive};
    }
}

template <int Width>
void trace_packets(const EmbreeScene& scene, std::span<const RayQuery<float>> queries,
                   QueryKind kind, std::span<QueryHit<float>> hits) {
    constexpr std::size_t packets_per_task = 256 / Width;
    const std::size_t packets = (queries.size() + Width - 1) / Width;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, packets, packets_per_task),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t packet = range.begin(); packet < range.end(); ++packet) {
                              const std::size_t first = packet * Width;
                              const std::size_t rays =
                                  std::min<std::size_t>(Width, queries.size() - first);
                              const auto part = queries.subspan(first, rays);
                              if (kind == QueryKind::any_hit) {
                                  trace_any<Width>(scene, part, &hits[first]);
                              } else {
                                  trace_closest<Width>(scene, part, &hits[first]);
                              }
                          }
                      });
}

void check_call(const EmbreeScene& scene, const EmbreeCall& call) {
    if (call.threads < 0) throw std::invalid_argument("threads must not be negative");
    if (call.repeats < 1) throw std::invalid_argument("repeats must be positive");
    if (call.width == 1) return;
    if (call.width != 8 && call.width != 16) {
        throw std::invalid_argument("width must be 1, 8 or 16, not " + std::to_string(call.width));
    }
    if (scene.has_spheres()) {
        throw std::invalid_argument("packets are not traced through spheres");
    }
    if (!scene.traces_packets_of(call.width)) {
        throw std::invalid_argument("Embree has no packets of " + std::to_string(call.width) +
                                    " rays on this processor");
    }
}

}  // namespace

EmbreeReplay replay_embree(const EmbreeScene& scene, const RayBatch& rays, QueryKind kind,
                           const EmbreeCall& call) {
    check_call(scene, call);
    const std::span queries = rays.queries();
    std::unique_ptr<tbb::global_control> limit;
    if (call.threads > 0) {
        limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                      std::size_t(call.threads));
    }
    EmbreeReplay output;
    output.hits.resize(queries.size());
    for (int repeat = 0; repeat < call.repeats; ++repeat) {
        const auto start = std::chrono::steady_clock::now();
        if (call.width == 8) {
            trace_packets<8>(scene, queries, kind, output.hits);
        } else if (call.width == 16) {
            trace_packets<16>(scene, queries, kind, output.hits);
        } else {
            embree_replay(kind)(&scene, queries, output.hits);
        }
        output.seconds.push_back(
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return output;
}

}  // namespace haste
