#include "cuda/device_scene.h"

#include <span>

#include "accel/bvh8_builder.h"
#include "host/stopwatch.h"

namespace haste::cuda {

template <class T>
void DeviceScene::upload(const std::vector<T>& host, DeviceBuffer<T>& buffer, const T*& pointer) {
    buffer = DeviceBuffer<T>(std::span<const T>(host));
    pointer = buffer.data();
    bytes_ += buffer.bytes();
}

DeviceScene::DeviceScene(const HostScene& scene) : view_(scene.view()) {
    const Stopwatch watch;
    const SceneArrays& arrays = scene.arrays();
    view_.nodes = nullptr;
    view_.parents = nullptr;
    view_.records = nullptr;
    view_.wide_nodes = nullptr;
    view_.wide_records = nullptr;
    upload(arrays.vertices, vertices_, view_.vertices);
    upload(arrays.normals, normals_, view_.normals);
    upload(arrays.triangles, triangles_, view_.triangles);
    upload(arrays.triangle_shape, triangle_shape_, view_.triangle_shape);
    upload(arrays.sphere_centre, sphere_centre_, view_.sphere_centre);
    upload(arrays.sphere_radius, sphere_radius_, view_.sphere_radius);
    upload(arrays.sphere_shape, sphere_shape_, view_.sphere_shape);
    upload(arrays.shapes, shapes_, view_.shapes);
    upload(arrays.materials, materials_, view_.materials);
    upload(arrays.lights, lights_, view_.lights);
    upload(scene.light_cdf(), light_cdf_, view_.light_cdf);
    upload_seconds_ = watch.seconds();
}

bool DeviceScene::has(TraversalKind traversal) const {
    switch (traversal) {
        case TraversalKind::bvh2:
            return view_.nodes != nullptr;
        case TraversalKind::bvh2_stackless:
            return view_.nodes != nullptr && view_.parents != nullptr;
        case TraversalKind::bvh8:
            return view_.wide_nodes != nullptr;
        default:
            return true;
    }
}

double DeviceScene::prepare(const HostScene& scene, TraversalKind traversal) {
    const Stopwatch watch;
    const bool stackless = traversal == TraversalKind::bvh2_stackless;
    if ((traversal == TraversalKind::bvh2 || stackless) && view_.nodes == nullptr) {
        upload(scene.nodes(), nodes_, view_.nodes);
        upload(scene.records(), records_, view_.records);
    }
    if (stackless && view_.parents == nullptr) upload(scene.parents(), parents_, view_.parents);
    if (traversal == TraversalKind::bvh8 && view_.wide_nodes == nullptr) {
        upload(scene.bvh8().nodes, wide_nodes_, view_.wide_nodes);
        upload(scene.bvh8().records, wide_records_, view_.wide_records);
    }
    return watch.seconds();
}

}  // namespace haste::cuda
