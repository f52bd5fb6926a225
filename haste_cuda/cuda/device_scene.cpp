#include "cuda/device_scene.h"

#include "host/stopwatch.h"

namespace haste::cuda {

DeviceScene::DeviceScene(const HostScene& scene) : view_(scene.view()) {
    const Stopwatch watch;
    const auto upload = [this]<class T>(const std::vector<T>& host, DeviceBuffer<T>& buffer,
                                        const T*& pointer) {
        buffer = DeviceBuffer<T>(std::span<const T>(host));
        pointer = buffer.data();
        bytes_ += buffer.bytes();
    };
    const SceneArrays& arrays = scene.arrays();
    upload(scene.nodes(), nodes_, view_.nodes);
    upload(scene.records(), records_, view_.records);
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

}  // namespace haste::cuda
