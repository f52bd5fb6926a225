#pragma once

#include "accel/host_scene.h"

namespace haste {

/// A scene in double precision, each number that of the scene in single precision; hierarchy and
/// indices are the other scene's, which must live as long.
class SceneFp64 {
public:
    explicit SceneFp64(const HostScene& scene);

    [[nodiscard]] SceneView<double> view() const;

private:
    const HostScene& scene_;
    std::vector<PrimitiveRecord<double>> records_;
    std::vector<Vec3<double>> vertices_;
    std::vector<Vec3<double>> normals_;
    std::vector<Vec3<double>> sphere_centre_;
    std::vector<double> sphere_radius_;
    std::vector<Material<double>> materials_;
    std::vector<Light<double>> lights_;
    std::vector<double> light_cdf_;
};

/// Render settings likewise.
[[nodiscard]] Settings<double> to_fp64(const Settings<float>& settings);

}  // namespace haste
