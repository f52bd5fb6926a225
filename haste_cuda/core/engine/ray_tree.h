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

    /// All rays of one sample, 2^62 where there may be more.
    HASTE_HD constexpr u64 most_rays() const {
        constexpr u64 most = u64(1) << 62;
        u64 rays = 0;
        u64 generation = 1;
        for (u32 i = 0; i < generations; ++i) {
            rays += generation;
            if (rays >= most) return most;
            generation =
                children != 0 && generation > most / children ? most : generation * children;
        }
        return rays;
    }
};

}  // namespace haste
