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

/// How Embree tests boxes and triangles: `robust` misses nothing between two triangles that share
/// an edge, `fast` may.
enum class EmbreeMode : u32 { robust, fast };

/// A scene on Embree's own hierarchy and traversal. One geometry a mesh; one user geometry, tested
/// by the core's sphere test, for all spheres.
class EmbreeScene {
public:
    /// `scene` must outlive this. Throws std::runtime_error with Embree's message.
    EmbreeScene(const HostScene& scene, int threads, EmbreeMode mode = EmbreeMode::robust);

    [[nodiscard]] Hit<float> closest(const Ray<float>& ray) const;
    [[nodiscard]] Hit<float> closest(const RayQuery<float>& query) const;
    [[nodiscard]] bool occluded(const ShadowRay<float>& ray) const;
    [[nodiscard]] bool any_hit(const RayQuery<float>& query) const;

    [[nodiscard]] RTCScene handle() const { return scene_.get(); }
    /// The primitive of the import behind Embree's two numbers.
    [[nodiscard]] u32 primitive(u32 geometry, u32 index) const;
    [[nodiscard]] bool has_spheres() const { return !host_.arrays().sphere_radius.empty(); }
    /// Whether Embree traces packets of so many rays (8 or 16) as packets on this processor.
    [[nodiscard]] bool traces_packets_of(int width) const;

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
