#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <stdexcept>

#include "bindings/arrays.h"
#include "bindings/bindings.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace haste {

namespace {

using Rgb = std::array<float, 3>;
using Point = std::array<double, 3>;

Vec3f vec(const Rgb& v) { return {v[0], v[1], v[2]}; }
Vec3f vec(const Point& v) { return {float(v[0]), float(v[1]), float(v[2])}; }

std::vector<Vec3f> points(const Points& array) {
    const auto* data = reinterpret_cast<const Vec3f*>(array.data());
    return {data, data + array.shape(0)};
}

std::vector<u32> indices(const Indices& array) {
    return {array.data(), array.data() + array.size()};
}

Material<float> make_material(const std::string& kind, const Rgb& diffuse, const Rgb& specular,
                              const Rgb& ambient, float exponent, float reflection,
                              float transmission, float ior, bool twosided) {
    if (kind != "phong" && kind != "dielectric") {
        throw std::invalid_argument("material kind must be phong or dielectric, not " + kind);
    }
    return {vec(diffuse), vec(specular),
            vec(ambient), exponent,
            reflection,   transmission,
            ior,          kind == "phong" ? MaterialKind::phong : MaterialKind::dielectric,
            twosided};
}

Shape make_shape(const std::string& kind, u32 material, int light, u32 first, u32 count,
                 bool smooth, bool flip_normals) {
    if (kind != "mesh" && kind != "sphere") {
        throw std::invalid_argument("shape kind must be mesh or sphere, not " + kind);
    }
    return {material,    light < 0 ? no_light : u32(light), first, count, kind == "sphere", smooth,
            flip_normals};
}

Camera<float> make_camera(const Point& origin, const Point& corner, const Point& dx,
                          const Point& dy, double near_clip, u32 width, u32 height) {
    return {vec(origin), vec(corner), vec(dx), vec(dy), float(near_clip), width, height};
}

std::unique_ptr<SceneHandle> make_scene(
    const Points& vertices, const Points& normals, const Array<u32, nb::shape<-1, 3>>& triangles,
    const Indices& triangle_shape, const Array<float, nb::shape<-1, 4>>& spheres,
    const Indices& sphere_shape, const std::vector<Shape>& shapes,
    const std::vector<Material<float>>& materials, const std::vector<std::pair<u32, Rgb>>& lights,
    const Camera<float>& camera, const std::optional<Rgb>& environment, int threads) {
    SceneArrays arrays;
    arrays.vertices = points(vertices);
    arrays.normals = points(normals);
    arrays.triangles = {triangles.data(), triangles.data() + triangles.size()};
    arrays.triangle_shape = indices(triangle_shape);
    for (std::size_t i = 0; i < spheres.shape(0); ++i) {
        arrays.sphere_centre.push_back({spheres(i, 0), spheres(i, 1), spheres(i, 2)});
        arrays.sphere_radius.push_back(spheres(i, 3));
    }
    arrays.sphere_shape = indices(sphere_shape);
    arrays.shapes = shapes;
    arrays.materials = materials;
    for (const auto& [shape, radiance] : lights) {
        Light<float> light{};
        light.shape = shape;
        light.radiance = vec(radiance);
        arrays.lights.push_back(light);
    }
    arrays.camera = camera;
    if (environment) arrays.environment = vec(*environment);
    const nb::gil_scoped_release release;
    return std::make_unique<SceneHandle>(std::move(arrays), threads);
}

nb::dict bvh_info(const SceneHandle& scene) {
    const BvhInfo& info = scene.host().bvh();
    nb::dict result;
    result["build_seconds"] = info.build_seconds;
    result["nodes"] = info.nodes;
    result["records"] = info.records;
    result["bytes"] = info.bytes;
    result["depth"] = info.depth;
    result["sha256"] = info.sha256;
    return result;
}

nb::dict embree_info(SceneHandle& scene) {
    const EmbreeScene* embree = nullptr;
    {
        const nb::gil_scoped_release release;
        embree = &scene.embree();
    }
    nb::dict result;
    result["build_seconds"] = embree->build_seconds();
    result["bytes"] = embree->bytes();
    result["version"] = EmbreeScene::version();
    return result;
}

}  // namespace

void bind_scene(nb::module_& module) {
    nb::class_<Material<float>>(module, "Material", "A surface: Phong constants or a dielectric.")
        .def(nb::new_(&make_material), nb::kw_only(), "kind"_a = "phong", "diffuse"_a = Rgb{},
             "specular"_a = Rgb{}, "ambient"_a = Rgb{}, "exponent"_a = 30.0f, "reflection"_a = 0.0f,
             "transmission"_a = 0.0f, "ior"_a = 1.5f, "twosided"_a = false);
    nb::class_<Shape>(module, "Shape", "A mesh (a run of triangles) or one sphere.")
        .def(nb::new_(&make_shape), nb::kw_only(), "kind"_a, "material"_a, "light"_a = -1,
             "first"_a, "count"_a, "smooth"_a = false, "flip_normals"_a = false);
    nb::class_<Camera<float>>(
        module, "Camera", "A pinhole camera: direction(x, y) = corner + x dx + y dy, in pixels.")
        .def(nb::new_(&make_camera), nb::kw_only(), "origin"_a, "corner"_a, "dx"_a, "dy"_a,
             "near"_a, "width"_a, "height"_a)
        .def_ro("width", &Camera<float>::width)
        .def_ro("height", &Camera<float>::height);
    nb::class_<SceneHandle>(module, "Scene",
                            "A validated scene with its BVH. Arrays: vertices and normals float32 "
                            "[V, 3], triangles uint32 [T, 3], spheres float32 [S, 4] (centre, "
                            "radius). Raises ValueError naming what is wrong.")
        .def(nb::new_(&make_scene), nb::kw_only(), "vertices"_a, "normals"_a, "triangles"_a,
             "triangle_shape"_a, "spheres"_a, "sphere_shape"_a, "shapes"_a, "materials"_a,
             "lights"_a, "camera"_a, "environment"_a = nb::none(), "threads"_a = 0)
        .def_prop_ro("bvh", &bvh_info, "Seconds, size, depth and hash of the hierarchy.")
        .def_prop_ro("embree", &embree_info, "The same of Embree's scene; builds it on first use.")
        .def_prop_ro(
            "features", [](const SceneHandle& scene) { return scene.host().features(); },
            "Bit mask of what the scene requires.");
}

}  // namespace haste
