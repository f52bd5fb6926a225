#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/accel/traversal.h"
#include "core/base/features.h"
#include "core/base/scene_view.h"
#include "core/base/settings.h"
#include "core/film/fixed_point.h"

namespace haste {

using Vec3f = Vec3<float>;

/// The arrays that describe a scene, as import delivers them.
struct SceneArrays {
    std::vector<Vec3f> vertices;
    std::vector<Vec3f> normals;
    std::vector<u32> triangles;
    std::vector<u32> triangle_shape;
    std::vector<Vec3f> sphere_centre;
    std::vector<float> sphere_radius;
    std::vector<u32> sphere_shape;
    std::vector<Shape> shapes;
    std::vector<Material<float>> materials;
    std::vector<Light<float>> lights;  ///< radiance and shape; the rest is computed here
    Vec3f environment{};
    Camera<float> camera{};
};

/// What building the hierarchy cost and gave.
struct BvhInfo {
    double build_seconds = 0;
    std::size_t nodes = 0;
    std::size_t records = 0;
    std::size_t bytes = 0;
    u32 depth = 0;
    std::string sha256;  ///< of nodes and record order: films are comparable where it is equal
};

struct BuiltBvh8;

/// A validated scene in host memory with its hierarchies: the owner behind a `SceneView`.
class HostScene {
public:
    /// Builds the binary BVH. Throws std::invalid_argument naming the array and element that is
    /// wrong.
    HostScene(SceneArrays arrays, int threads);
    ~HostScene();

    /// What the traversal reads; builds the hierarchy that it needs on first use.
    [[nodiscard]] SceneView<float> view(TraversalKind traversal = small_scene_traversal) const;
    [[nodiscard]] u32 features() const { return features_; }
    [[nodiscard]] const BvhInfo& bvh() const { return bvh_; }
    /// Of the hierarchy of a traversal; builds it on first use.
    [[nodiscard]] BvhInfo bvh(TraversalKind traversal) const;
    [[nodiscard]] const SceneArrays& arrays() const { return arrays_; }
    [[nodiscard]] const std::vector<Bvh2Node>& nodes() const { return nodes_; }
    [[nodiscard]] const std::vector<u32>& parents() const { return parents_; }
    [[nodiscard]] const std::vector<PrimitiveRecord<float>>& records() const { return records_; }
    /// Built on first use.
    [[nodiscard]] const BuiltBvh8& bvh8() const;
    [[nodiscard]] const std::vector<float>& light_cdf() const { return light_cdf_; }

    /// The film's unit: 2^10 of head-room over the brightest emitter, `ambient` being one.
    [[nodiscard]] FixedPoint film_format(const Vec3f& ambient) const;

    /// The R of equation 8, one a scene: the mean of its reflection and transmission constants, a
    /// dielectric's taken for 1; 0 where nothing reflects.
    [[nodiscard]] double common_reflectance() const;

private:
    void validate() const;
    void complete_lights();
    void find_features();

    SceneArrays arrays_;
    int threads_;
    std::vector<float> light_cdf_;
    Box bounds_;
    std::vector<Bvh2Node> nodes_;
    std::vector<u32> parents_;
    std::vector<PrimitiveRecord<float>> records_;
    BvhInfo bvh_;
    mutable std::once_flag bvh8_once_;
    mutable std::unique_ptr<const BuiltBvh8> bvh8_;
    u32 features_ = 0;
};

}  // namespace haste
