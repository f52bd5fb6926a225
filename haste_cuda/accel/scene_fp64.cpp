#include "accel/scene_fp64.h"

namespace haste {

namespace {

double wide(float x) { return double(x); }

Vec3<double> wide(const Vec3f& v) { return {v.x, v.y, v.z}; }

PrimitiveRecord<double> wide(const PrimitiveRecord<float>& record) {
    return {wide(record.v0),  wide(record.v1), wide(record.v2),
            record.primitive, record.shape,    record.is_sphere};
}

Material<double> wide(const Material<float>& m) {
    return {wide(m.diffuse), wide(m.specular), wide(m.ambient),
            m.exponent,      m.reflection,     m.transmission,
            m.ior,           m.kind,           m.twosided};
}

Light<double> wide(const Light<float>& light) {
    return {wide(light.radiance), light.shape,  wide(light.centroid), light.area,
            wide(light.centre),   light.radius, light.first_cdf,      light.is_sphere};
}

Camera<double> wide(const Camera<float>& camera) {
    return {wide(camera.origin), wide(camera.corner), wide(camera.dx), wide(camera.dy),
            camera.near_clip,    camera.width,        camera.height};
}

template <class To, class From>
std::vector<To> all_wide(const std::vector<From>& narrow) {
    std::vector<To> result;
    result.reserve(narrow.size());
    for (const From& one : narrow) result.push_back(wide(one));
    return result;
}

}  // namespace

SceneFp64::SceneFp64(const HostScene& scene)
    : scene_(scene),
      records_(all_wide<PrimitiveRecord<double>>(scene.records())),
      vertices_(all_wide<Vec3<double>>(scene.arrays().vertices)),
      normals_(all_wide<Vec3<double>>(scene.arrays().normals)),
      sphere_centre_(all_wide<Vec3<double>>(scene.arrays().sphere_centre)),
      sphere_radius_(all_wide<double>(scene.arrays().sphere_radius)),
      materials_(all_wide<Material<double>>(scene.arrays().materials)),
      lights_(all_wide<Light<double>>(scene.arrays().lights)),
      light_cdf_(all_wide<double>(scene.light_cdf())) {}

SceneView<double> SceneFp64::view() const {
    const SceneView<float> narrow = scene_.view();
    SceneView<double> view{};
    view.bounds = narrow.bounds;
    view.nodes = narrow.nodes;
    view.parents = narrow.parents;
    view.records = records_.data();
    view.vertices = vertices_.data();
    view.normals = normals_.data();
    view.triangles = narrow.triangles;
    view.triangle_shape = narrow.triangle_shape;
    view.sphere_centre = sphere_centre_.data();
    view.sphere_radius = sphere_radius_.data();
    view.sphere_shape = narrow.sphere_shape;
    view.triangle_count = narrow.triangle_count;
    view.sphere_count = narrow.sphere_count;
    view.shapes = narrow.shapes;
    view.materials = materials_.data();
    view.lights = lights_.data();
    view.light_cdf = light_cdf_.data();
    view.light_count = narrow.light_count;
    view.environment = wide(narrow.environment);
    view.camera = wide(narrow.camera);
    return view;
}

Settings<double> to_fp64(const Settings<float>& settings) {
    return {settings.max_depth,       settings.rr_depth,
            settings.max_layers,      settings.light_samples,
            settings.ambient_samples, wide(settings.ambient),
            settings.clamp,           settings.seed};
}

}  // namespace haste
