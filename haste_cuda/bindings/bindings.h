#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "accel/host_scene.h"
#include "core/precision.h"
#include "cpu/ray_batch.h"
#include "cuda/render.h"
#include "reference/embree/embree_scene.h"

namespace haste {

/// A scene as Python holds it: host arrays and our BVH, Embree's scene once it is asked for.
class SceneHandle {
public:
    SceneHandle(SceneArrays arrays, int threads)
        : host_(std::move(arrays), threads), threads_(threads) {}

    [[nodiscard]] const HostScene& host() const { return host_; }

    /// Builds Embree's scene on first use.
    [[nodiscard]] const EmbreeScene& embree(EmbreeMode mode = EmbreeMode::robust) {
        const std::lock_guard lock(mutex_);
        std::unique_ptr<EmbreeScene>& scene = embree_[std::size_t(mode)];
        if (!scene) scene = std::make_unique<EmbreeScene>(host_, threads_, mode);
        return *scene;
    }

    /// The scene on the GPU, filled by the renderer on first use.
    [[nodiscard]] std::shared_ptr<cuda::Renderer::Scene>& device() { return device_; }

private:
    HostScene host_;
    int threads_;
    std::mutex mutex_;
    std::array<std::unique_ptr<EmbreeScene>, 2> embree_;  ///< by mode
    std::shared_ptr<cuda::Renderer::Scene> device_;
};

/// Rays as Python holds them: in the host's memory, and on the GPU from a first replay there on.
class RaysHandle {
public:
    explicit RaysHandle(std::vector<RayQuery<float>> queries) : host_(std::move(queries)) {}

    [[nodiscard]] const RayBatch& host() const { return host_; }
    [[nodiscard]] std::size_t size() const { return host_.size(); }

    /// The rays on the GPU, filled by the renderer on first use.
    [[nodiscard]] std::shared_ptr<cuda::Renderer::Rays>& device() { return device_; }

private:
    RayBatch host_;
    std::shared_ptr<cuda::Renderer::Rays> device_;
};

/// The precision of a name. Throws std::invalid_argument naming those that there are.
PrecisionKind precision_of(const std::string& name);

/// The dict that a render returns to Python.
nanobind::dict to_dict(RenderOutput output, const Camera<float>& camera);

/// Throws std::invalid_argument naming those that there are.
TraversalKind traversal_of(const std::string& name);

/// Adds ``t`` and ``primitive`` of hits to what a replay returns to Python.
void add_hits(nanobind::dict& result, std::span<const QueryHit<float>> hits);

void bind_scene(nanobind::module_& module);
void bind_render(nanobind::module_& module);
void bind_replay(nanobind::module_& module);
void bind_embree_replay(nanobind::module_& module);
void bind_testing(nanobind::module_& module);

}  // namespace haste
