#pragma once

#include <memory>
#include <string>
#include <vector>

#include "accel/host_scene.h"
#include "core/base/hit.h"
#include "core/base/ray.h"
#include "core/base/ray_query.h"
#include "reference/embree/embree_api.h"

namespace haste {

/// A scene on Embree's own hierarchy and traversal, in its robust mode. One geometry a mesh; one
/// user geometry, tested by the core's sphere test, for all spheres.
class EmbreeScene {
public:
    /// `scene` must outlive this. Throws std::runtime_error with Embree's message.
    EmbreeScene(const HostScene& scene, int threads);

    [[nodiscard]] Hit<float> closest(const Ray<float>& ray) const;
    [[nodiscard]] Hit<float> closest(const RayQuery<float>& query) const;
    [[nodiscard]] bool occluded(const ShadowRay<float>& ray) const;
    [[nodiscard]] bool any_hit(const RayQuery<float>& query) const;

    [[nodiscard]] double build_seconds() const { return build_seconds_; }
    [[nodiscard]] std::size_t bytes() const { return bytes_; }
    /// The library's own version, as it is loaded.
    [[nodiscard]] static std::string version();

private:
    struct ReleaseDevice {
        void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    };
    struct ReleaseScene {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };

    void attach_mesh(u32 shape);
    void attach_spheres();
    [[nodiscard]] Hit<float> closest(const RTCRay& ray) const;
    [[nodiscard]] bool occluded(RTCRay ray, u32 owner) const;

    const HostScene& host_;
    std::unique_ptr<RTCDeviceTy, ReleaseDevice> device_;
    std::unique_ptr<RTCSceneTy, ReleaseScene> scene_;
    u32 sphere_geometry_;
    std::size_t bytes_ = 0;
    double build_seconds_ = 0;
};

}  // namespace haste
