#include "cuda/engines/engine.h"

#include "cuda/engines/depth_first.h"
#include "cuda/engines/layers.h"
#include "cuda/engines/packets.h"
#include "cuda/engines/persistent.h"
#include "cuda/engines/streams.h"
#include "cuda/engines/wavefront.h"

namespace haste::cuda {

std::unique_ptr<Engine> make_engine(const EngineRequest& request) {
    switch (request.schedule.engine) {
        case EngineKind::depth_first:
            return std::make_unique<DepthFirstEngine>(request);
        case EngineKind::packets:
            return std::make_unique<PacketsEngine>(request);
        case EngineKind::layers:
            return std::make_unique<LayersEngine>(request);
        case EngineKind::wavefront:
            return std::make_unique<WavefrontEngine>(request);
        case EngineKind::streams:
            return std::make_unique<StreamsEngine>(request);
        default:
            return std::make_unique<PersistentEngine>(request);
    }
}

}  // namespace haste::cuda
