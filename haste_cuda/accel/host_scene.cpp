#include "accel/host_scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "accel/bvh8_builder.h"

namespace haste {

namespace {

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("scene: " + what); }

bool finite(const Vec3f& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check_index(const char* array, std::size_t i, u32 index, std::size_t size) {
    if (index >= size) {
        refuse(std::string(array) + "[" + std::to_string(i) + "] = " + std::to_string(index) +
               " is out of range (" + std::to_string(size) + ")");
    }
}

}  // namespace

HostScene::HostScene(SceneArrays arrays, int threads)
    : arrays_(std::move(arrays)), threads_(threads) {
    validate();
    complete_lights();
    find_features();
    BuiltBvh built = build_bvh2(arrays_, threads);
    bounds_ = built.bounds;
    nodes_ = std::move(built.nodes);
    parents_ = std::move(built.parents);
    records_ = std::move(built.records);
    bvh_ = std::move(built.info);
}

HostScene::~HostScene() = default;

const BuiltBvh8& HostScene::bvh8() const {
    std::call_once(bvh8_once_, [this] {
        // Single primitives, of which the collapse makes leaves; few splits, for every copy of a
        // triangle is 48 bytes.
        const BuildQuality quality{.max_leaf = 1, .most_splits = 0.05};
        bvh8_ = std::make_unique<BuiltBvh8>(build_bvh8(build_bvh2(arrays_, threads_, quality)));
    });
    return *bvh8_;
}

BvhInfo HostScene::bvh(TraversalKind traversal) const {
    switch (traversal) {
        case TraversalKind::brute_force:
            return {};
        case TraversalKind::bvh2:
            return bvh_;
        case TraversalKind::bvh2_stackless: {
            BvhInfo info = bvh_;
            info.bytes += parents_.size() * sizeof(u32);
            return info;
        }
        default:
            return bvh8().info;
    }
}

void HostScene::validate() const {
    const SceneArrays& a = arrays_;
    if (a.triangles.empty() && a.sphere_radius.empty()) refuse("it has no triangle and no sphere");
    if (a.triangles.size() != 3 * a.triangle_shape.size()) {
        refuse("triangle_shape must have one entry a triangle");
    }
    if (a.normals.size() != a.vertices.size()) refuse("normals must have one entry a vertex");
    if (a.sphere_centre.size() != a.sphere_radius.size() ||
        a.sphere_shape.size() != a.sphere_radius.size()) {
        refuse("sphere arrays differ in length");
    }
    for (std::size_t i = 0; i < a.vertices.size(); ++i) {
        if (!finite(a.vertices[i])) refuse("vertex " + std::to_string(i) + " is not finite");
    }
    for (std::size_t i = 0; i < a.triangles.size(); ++i) {
        check_index("triangles", i, a.triangles[i], a.vertices.size());
    }
    for (std::size_t i = 0; i < a.triangle_shape.size(); ++i) {
        check_index("triangle_shape", i, a.triangle_shape[i], a.shapes.size());
    }
    for (std::size_t i = 0; i < a.sphere_radius.size(); ++i) {
        check_index("sphere_shape", i, a.sphere_shape[i], a.shapes.size());
        if (!finite(a.sphere_centre[i]) || !(a.sphere_radius[i] > 0) ||
            !std::isfinite(a.sphere_radius[i])) {
            refuse("sphere " + std::to_string(i) + " has no finite centre and positive radius");
        }
    }
    for (std::size_t i = 0; i < a.shapes.size(); ++i) {
        const Shape& shape = a.shapes[i];
        check_index("shape material", i, shape.material, a.materials.size());
        if (shape.light != no_light) check_index("shape light", i, shape.light, a.lights.size());
        const std::size_t primitives =
            shape.is_sphere ? a.sphere_radius.size() : a.triangle_shape.size();
        if (std::size_t(shape.first) + shape.count > primitives) {
            refuse("shape " + std::to_string(i) + " names primitives that do not exist");
        }
    }
    for (std::size_t i = 0; i < a.lights.size(); ++i) {
        check_index("light shape", i, a.lights[i].shape, a.shapes.size());
        if (a.shapes[a.lights[i].shape].light != i) {
            refuse("light " + std::to_string(i) + " and its shape do not name each other");
        }
    }
    if (a.camera.width == 0 || a.camera.height == 0) refuse("the camera's film has no pixel");
}

void HostScene::complete_lights() {
    SceneArrays& a = arrays_;
    for (std::size_t i = 0; i < a.lights.size(); ++i) {
        Light<float>& light = a.lights[i];
        const Shape& shape = a.shapes[light.shape];
        light.is_sphere = shape.is_sphere;
        light.first_cdf = u32(light_cdf_.size());
        light.centre = {};
        light.radius = 0;
        if (shape.is_sphere) {
            light.centre = a.sphere_centre[shape.first];
            light.radius = a.sphere_radius[shape.first];
            light.centroid = light.centre;
            light.area = float(4 * M_PI * double(light.radius) * double(light.radius));
            continue;
        }
        double area = 0;
        Vec3<double> moment{};
        for (u32 t = shape.first; t < shape.first + shape.count; ++t) {
            Vec3<double> v[3];
            for (int k = 0; k < 3; ++k) {
                const Vec3f& p = a.vertices[a.triangles[3 * std::size_t(t) + k]];
                v[k] = {p.x, p.y, p.z};
            }
            const double triangle_area = 0.5 * length(cross(v[1] - v[0], v[2] - v[0]));
            area += triangle_area;
            moment += (v[0] + v[1] + v[2]) * (triangle_area / 3);
            light_cdf_.push_back(float(area));
        }
        if (!(area > 0)) refuse("light " + std::to_string(i) + " has no area");
        // The last entry is the area itself, so that a sample below it always finds a triangle.
        light.area = float(area);
        const Vec3<double> centroid = moment * (1 / area);
        light.centroid = {float(centroid.x), float(centroid.y), float(centroid.z)};
    }
}

void HostScene::find_features() {
    const SceneArrays& a = arrays_;
    const auto require = [&](bool needed, u32 feature) {
        if (needed) features_ |= feature;
    };
    require(!a.triangles.empty(), feature_triangles);
    require(!a.sphere_radius.empty(), feature_spheres);
    std::vector<bool> used(a.materials.size());
    for (const Shape& shape : a.shapes) {
        if (shape.count == 0) continue;
        used[shape.material] = true;
        require(shape.smooth, feature_smooth_normals);
    }
    for (const Light<float>& light : a.lights) {
        require(true, light.is_sphere ? feature_sphere_lights : feature_mesh_lights);
    }
    for (std::size_t i = 0; i < a.materials.size(); ++i) {
        if (!used[i]) continue;
        const Material<float>& material = a.materials[i];
        const bool dielectric = material.kind == MaterialKind::dielectric;
        require(dielectric, feature_dielectric);
        require(!is_zero(material.diffuse), feature_diffuse);
        require(!is_zero(material.specular), feature_specular);
        require(!dielectric && material.reflection > 0, feature_mirror);
        require(!dielectric && material.transmission > 0, feature_transmission);
        require(material.twosided, feature_twosided);
        require(!is_zero(material.ambient), feature_ambient);
    }
    const bool environment = !is_zero(a.environment);
    require(environment, feature_environment);
    require(a.lights.size() + (environment ? 1 : 0) > 1, feature_several_lights);
}

SceneView<float> HostScene::view(TraversalKind traversal) const {
    const SceneArrays& a = arrays_;
    SceneView<float> view{};
    view.bounds = bounds_;
    view.nodes = nodes_.data();
    view.parents = parents_.data();
    view.records = records_.data();
    if (traversal == TraversalKind::bvh8) {
        view.wide_nodes = bvh8().nodes.data();
        view.wide_records = bvh8().records.data();
    }
    view.vertices = a.vertices.data();
    view.normals = a.normals.data();
    view.triangles = a.triangles.data();
    view.triangle_shape = a.triangle_shape.data();
    view.sphere_centre = a.sphere_centre.data();
    view.sphere_radius = a.sphere_radius.data();
    view.sphere_shape = a.sphere_shape.data();
    view.triangle_count = u32(a.triangle_shape.size());
    view.sphere_count = u32(a.sphere_radius.size());
    view.shapes = a.shapes.data();
    view.materials = a.materials.data();
    view.lights = a.lights.data();
    view.light_cdf = light_cdf_.data();
    view.light_count = u32(a.lights.size());
    view.environment = a.environment;
    view.camera = a.camera;
    return view;
}

FixedPoint HostScene::film_format(const Settings<float>& settings) const {
    constexpr int head_room_bits = 10;
    float brightest = std::max(max_component(arrays_.environment), max_component(settings.ambient));
    for (const Light<float>& light : arrays_.lights) {
        brightest = std::max(brightest, max_component(light.radiance));
    }
    if (!(brightest > 0)) brightest = 1;
    return {std::ilogb(brightest) + 1 + head_room_bits - FixedPoint::range_bits};
}

double HostScene::common_reflectance() const {
    double sum = 0;
    int constants = 0;
    for (const Material<float>& material : arrays_.materials) {
        const bool dielectric = material.kind == MaterialKind::dielectric;
        for (const float constant :
             {dielectric ? 1.0f : material.reflection, dielectric ? 0.0f : material.transmission}) {
            if (constant == 0.0f) continue;
            sum += double(constant);
            ++constants;
        }
    }
    return constants == 0 ? 0.0 : sum / constants;
}

}  // namespace haste
