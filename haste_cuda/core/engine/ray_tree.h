#pragma once

#include "core/config.h"

namespace haste {

/// What the rays of one sample can grow to: the bound behind every queue's size.
struct RayTree {
    u32 generations;  ///< rays on the longest way from the camera to a leaf, both ends counted
    u32 children;     ///< most rays that one ray spawns

    /// Most rays that wait where a sample is walked last in, first out: every generation but the
    /// first leaves all its children but one behind.
    HASTE_HD constexpr u64 lifo_need() const { return u64(generations - 1) * (children - 1) + 1; }
};

}  // namespace haste
