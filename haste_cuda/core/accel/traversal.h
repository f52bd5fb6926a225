#pragma once

#include "core/accel/brute_force_intersector.h"
#include "core/accel/bvh2_intersector.h"
#include "core/accel/bvh2_stackless_intersector.h"
#include "core/accel/bvh8_intersector.h"
#include "core/base/traversal_kind.h"

namespace haste {

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
using ImageIntersector = IntersectorOf<small_scene_traversal, P, F>;

}  // namespace haste
