#pragma once

#include "core/config.h"

namespace haste {

/// The ways to find what a ray hits. All find the same.
enum class TraversalKind : u32 { brute_force, bvh2, bvh2_stackless, bvh8 };

inline constexpr u32 traversal_count = 4;
inline constexpr const char* traversal_names[traversal_count] = {"brute_force", "bvh2",
                                                                 "bvh2_stackless", "bvh8"};

/// Of replays that name none, whose rays are all of one kind.
inline constexpr TraversalKind default_traversal = TraversalKind::bvh8;

/// Of images on the processor, and of small scenes' on the GPU: docs/performance.md has what the
/// others cost there.
inline constexpr TraversalKind small_scene_traversal = TraversalKind::bvh2;

HASTE_HD constexpr const char* name_of(TraversalKind kind) { return traversal_names[u32(kind)]; }

}  // namespace haste
