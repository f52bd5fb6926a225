#pragma once

#include "core/config.h"

namespace haste {

inline constexpr u32 warp_size = 32;
inline constexpr u32 whole_warp = 0xffffffffu;

__device__ inline u32 lane_index() { return threadIdx.x % warp_size; }

/// The lanes before this one.
__device__ inline u32 lanes_below() { return (1u << lane_index()) - 1; }

}  // namespace haste
