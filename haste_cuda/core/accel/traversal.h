#pragma once

#include "core/accel/brute_force_intersector.h"
#include "core/accel/bvh2_intersector.h"
#include "core/accel/bvh2_stackless_intersector.h"
#include "core/accel/bvh8_intersector.h"

namespace haste {

/// The ways to find what a ray hits. All find the same.
enum class TraversalKind : u32 { brute_force, bvh2, bvh2_stackless, bvh8 };

inline constexpr u32 traversal_count = 4;
inline constexpr const char* traversal_names[traversal_count] = {"brute_force", "bvh2",
                                                                 "bvh2_stackless", "bvh8"};

/// That of images, and of replays that name none.
inline constexpr TraversalKind default_traversal = TraversalKind::bvh2;

HASTE_HD constexpr const char* name_of(TraversalKind kind) { return traversal_names[u32(kind)]; }

/// The intersector of each kind.
template <TraversalKind K, class P, class F, class T = NoTally>
struct TraversalOf;

template <class P, class F, class T>
struct TraversalOf<TraversalKind::brute_force, P, F, T> {
    using Type = BruteForceIntersector<P, F, T>;
};

template <class P, class F, class T>
struct TraversalOf<TraversalKind::bvh2, P, F, T> {
    using Type = Bvh2Intersector<P, F, T>;
};

template <class P, class F, class T>
struct TraversalOf<TraversalKind::bvh2_stackless, P, F, T> {
    using Type = Bvh2StacklessIntersector<P, F, T>;
};

template <class P, class F, class T>
struct TraversalOf<TraversalKind::bvh8, P, F, T> {
    using Type = Bvh8Intersector<P, F, T>;
};

template <TraversalKind K, class P, class F, class T = NoTally>
using IntersectorOf = typename TraversalOf<K, P, F, T>::Type;

template <class P, class F>
using DefaultIntersector = IntersectorOf<default_traversal, P, F>;

}  // namespace haste
