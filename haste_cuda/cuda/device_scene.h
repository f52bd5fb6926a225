#pragma once

#include "accel/host_scene.h"
#include "cuda/memory.h"

namespace haste::cuda {

/// A scene in device memory: the owner behind a `SceneView` of device pointers.
class DeviceScene {
public:
    /// Uploads all arrays but the hierarchies. A context must be current. Throws CudaError.
    explicit DeviceScene(const HostScene& scene);

    /// Whether what the traversal reads is there.
    [[nodiscard]] bool has(TraversalKind traversal) const;

    /// Uploads what it reads, of which no part need be there; returns the seconds that this took.
    /// Throws CudaError.
    double prepare(const HostScene& scene, TraversalKind traversal);

    [[nodiscard]] const SceneView<float>& view() const { return view_; }
    [[nodiscard]] std::size_t bytes() const { return bytes_; }
    [[nodiscard]] double upload_seconds() const { return upload_seconds_; }

private:
    template <class T>
    void upload(const std::vector<T>& host, DeviceBuffer<T>& buffer, const T*& pointer);

    DeviceBuffer<Bvh2Node> nodes_;
    DeviceBuffer<u32> parents_;
    DeviceBuffer<PrimitiveRecord<float>> records_;
    DeviceBuffer<Bvh8Node> wide_nodes_;
    DeviceBuffer<PrimitiveRecord<float>> wide_records_;
    DeviceBuffer<Vec3f> vertices_;
    DeviceBuffer<Vec3f> normals_;
    DeviceBuffer<u32> triangles_;
    DeviceBuffer<u32> triangle_shape_;
    DeviceBuffer<Vec3f> sphere_centre_;
    DeviceBuffer<float> sphere_radius_;
    DeviceBuffer<u32> sphere_shape_;
    DeviceBuffer<Shape> shapes_;
    DeviceBuffer<Material<float>> materials_;
    DeviceBuffer<Light<float>> lights_;
    DeviceBuffer<float> light_cdf_;
    SceneView<float> view_;
    std::size_t bytes_ = 0;
    double upload_seconds_ = 0;
};

}  // namespace haste::cuda
