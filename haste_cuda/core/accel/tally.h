#pragma once

#include "core/config.h"

namespace haste {

/// Counts nothing and costs nothing: what timed traversals are given.
struct NoTally {
    HASTE_HD static void node(NoTally*) {}
    HASTE_HD static void primitive(NoTally*) {}
};

/// Nodes and primitives that traversals visited.
struct Tally {
    u64 nodes = 0;
    u64 primitives = 0;

    HASTE_HD static void node(Tally* tally) { ++tally->nodes; }
    HASTE_HD static void primitive(Tally* tally) { ++tally->primitives; }
};

}  // namespace haste
