#pragma once

#include <memory>
#include <string>

#include "accel/host_scene.h"
#include "cpu/replay.h"
#include "engine/render_output.h"
#include "engine/schedule.h"

namespace haste::cuda {

/// A render and the figures of its kernel.
struct CudaOutput {
    RenderOutput render;
    std::string traversal;
    double compile_seconds = 0;   ///< to compile or load the kernels; 0 once they are in memory
    bool compile_cached = false;  ///< the main kernel came from the cache
    double upload_seconds = 0;    ///< 0 once the scene is on the device
    int registers = 0;            ///< of the engine's main kernel
    int local_bytes = 0;
    std::size_t scene_bytes = 0;
};

/// How a replay is run on the GPU: it changes no hit.
struct CudaReplaySchedule {
    TraversalKind traversal = default_traversal;
    PrecisionKind precision = PrecisionKind::watertight;  ///< or fast
    int block = 128;                                      ///< threads
    int repeats = 1;
    bool count = false;  ///< counts what is visited, in one repeat more that is not timed
    bool hits = true;    ///< copies them back
};

/// A replay and the figures of its kernel and copies.
struct CudaReplayOutput {
    ReplayOutput replay;              ///< seconds by the device's clock, the kernel alone
    double compile_seconds = 0;       ///< to compile or load the kernel
    double scene_upload_seconds = 0;  ///< 0 once the scene is on the device
    double upload_seconds = 0;        ///< copying the rays; 0 once they are on the device
    double download_seconds = 0;      ///< copying the hits back; 0 where they are not wanted
    int registers = 0;
};

/// One GPU with its kernels, shared by all scenes of the process. Throws CudaError without a GPU.
class Renderer {
public:
    static Renderer& instance();
    ~Renderer();

    /// A scene, and rays, on this device: opaque to those who only keep them.
    struct Scene;
    struct Rays;

    /// Renders by the schedule's engine. `scene` is filled on first use.
    /// Throws CudaError, std::invalid_argument and FilmOverflow.
    CudaOutput render(const HostScene& host, std::shared_ptr<Scene>& scene, ModelKind model,
                      const Settings<float>& settings, u32 samples, const Schedule& schedule);

    /// Traces rays for their own sake. `scene` and `device_rays` are filled on first use: as long
    /// as they are kept, neither is copied again. Throws CudaError and std::invalid_argument.
    CudaReplayOutput replay(const HostScene& host, std::shared_ptr<Scene>& scene,
                            const RayBatch& rays, std::shared_ptr<Rays>& device_rays,
                            QueryKind kind, const CudaReplaySchedule& schedule);

private:
    Renderer();
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace haste::cuda
