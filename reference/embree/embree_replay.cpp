#include "cpu/replay_loop.h"
#include "reference/embree/embree_scene.h"

namespace haste {

ReplayLoop embree_replay(QueryKind kind) { return replay_loop_of<EmbreeScene>(kind); }

}  // namespace haste
