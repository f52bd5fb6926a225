#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "cpu/replay.h"

namespace haste {

/// Answers all queries on an intersector of type `I`.
template <QueryKind Kind, class I>
void replay_loop(const void* intersector, std::span<const RayQuery<float>> queries,
                 std::span<QueryHit<float>> hits) {
    const I& scene = *static_cast<const I*>(intersector);
    constexpr std::size_t rays_per_task = 256;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, queries.size(), rays_per_task),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i < range.end(); ++i) {
                              hits[i] = answer<Kind>(scene, queries[i]);
                          }
                      });
}

/// The loop of a kind of query.
template <class I>
ReplayLoop replay_loop_of(QueryKind kind) {
    return kind == QueryKind::any_hit ? &replay_loop<QueryKind::any_hit, I>
                                      : &replay_loop<QueryKind::closest, I>;
}

}  // namespace haste
