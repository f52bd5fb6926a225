#pragma once

#include "core/config.h"

namespace haste {

/// Stack entries of a thread of a resident kernel that lie in shared memory, eight bytes each.
inline constexpr u32 shared_stack_entries = 8;

/// Most threads of a block of a resident kernel, whose stacks must fit shared memory.
inline constexpr int max_resident_block = 512;

}  // namespace haste
