#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "accel/bvh8_builder.h"
#include "bindings/arrays.h"
#include "bindings/bindings.h"
#include "core/accel/traversal.h"
#include "core/engine/admission.h"
#include "core/features/all.h"
#include "core/geometry/surface.h"
#include "core/math/elementary.h"
#include "core/model/phong_bsdf.h"
#include "core/precision.h"
#include "core/sampling/light_sample.h"
#include "core/sampling/warp.h"
#include "cpu/planted.h"
#include "cuda/engines/wavefront_room.h"
#include "cuda/kernels/wavefront_params.h"
#include "engine/ray_queue.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace haste {

namespace {

void require_same(std::size_t a, std::size_t b) {
    if (a != b) throw std::invalid_argument("arrays differ in length");
}

nb::object points_to_numpy(const std::vector<Vec3f>& points) {
    std::vector<float> flat;
    for (const Vec3f& p : points) flat.insert(flat.end(), {p.x, p.y, p.z});
    return to_numpy(std::move(flat), {points.size(), 3});
}

nb::object philox(const std::array<u32, 4>& counter, const std::array<u32, 2>& key) {
    const PhiloxBlock block =
        philox4x32({{counter[0], counter[1], counter[2], counter[3]}}, key[0], key[1]);
    return nb::make_tuple(block.word[0], block.word[1], block.word[2], block.word[3]);
}

nb::object sin_cos(const Reals& turns) {
    std::vector<float> flat;
    for (std::size_t i = 0; i < turns.size(); ++i) {
        const SinCos<float> value = sin_cos_of_turn(turns(i));
        flat.insert(flat.end(), {value.sine, value.cosine});
    }
    return to_numpy(std::move(flat), {turns.size(), 2});
}

template <class Real>
Real elementary(const std::string& name, Real x) {
    if (name == "exp") return exponential(x);
    if (name == "expm1") return exponential_minus_one(x);
    if (name == "log1p") return logarithm_of_one_plus(x);
    if (name == "cbrt") return cube_root(x);
    throw std::invalid_argument("no elementary function is called " + name);
}

/// An elementary function in single precision, and in double precision.
nb::object elementary_values(const std::string& name, const Reals& values) {
    std::vector<float> single;
    std::vector<double> twice;
    for (std::size_t i = 0; i < values.size(); ++i) {
        single.push_back(elementary(name, values(i)));
        twice.push_back(elementary(name, double(values(i))));
    }
    const std::size_t n = single.size();
    return nb::make_tuple(to_numpy(std::move(single), {n}), to_numpy(std::move(twice), {n}));
}

Vec3f warp(const std::string& name, float u, float v, float w, float parameter) {
    if (name == "sphere") return uniform_sphere(u, v);
    if (name == "hemisphere") return uniform_hemisphere(u, v);
    if (name == "cosine") return cosine_hemisphere(u, v);
    if (name == "ball") return uniform_ball(u, v, w);
    if (name == "cone") return uniform_cone(u, v, parameter);
    if (name == "phong") return phong_lobe(u, v, parameter);
    if (name == "triangle") {
        const Barycentrics<float> b = uniform_triangle(u, v);
        return {1.0f - b.b1 - b.b2, b.b1, b.b2};
    }
    throw std::invalid_argument("no warp is called " + name);
}

nb::object warp_points(const std::string& name, const Points& numbers, float parameter) {
    std::vector<Vec3f> result;
    for (std::size_t i = 0; i < numbers.shape(0); ++i) {
        const Vec3f u = point(numbers, i);
        result.push_back(warp(name, u.x, u.y, u.z, parameter));
    }
    return points_to_numpy(result);
}

/// Directions towards a light from some points, and their densities per solid angle.
nb::object light_directions(SceneHandle& scene, u32 light, const Points& from,
                            const Points& numbers) {
    require_same(from.shape(0), numbers.shape(0));
    const SceneView<float> view = scene.host().view();
    if (light >= view.light_count) throw std::invalid_argument("there is no such light");
    std::vector<Vec3f> directions;
    std::vector<float> pdf;
    for (std::size_t i = 0; i < from.shape(0); ++i) {
        const Vec3f u = point(numbers, i);
        const LightDirection<float> sample = sample_light_direction<Features<all_features>>(
            view, view.lights[light], point(from, i), u.x, u.y, u.z);
        directions.push_back(sample.direction);
        pdf.push_back(sample.pdf);
    }
    const std::size_t n = pdf.size();
    return nb::make_tuple(points_to_numpy(directions), to_numpy(std::move(pdf), {n}));
}

nb::object convert(const Reals& values, int exponent, u32 rounding) {
    std::vector<i64> units(values.size());
    std::vector<u32> status(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        status[i] = FixedPoint{exponent}.convert(values(i), rounding, units[i]);
    }
    const std::size_t n = values.size();
    return nb::make_tuple(to_numpy(std::move(units), {n}), to_numpy(std::move(status), {n}));
}

Ray<float> bare_ray(const Vec3f& origin, const Vec3f& direction) {
    Ray<float> ray{};
    ray.origin = origin;
    ray.direction = direction;
    return ray;
}

using EveryFeature = Features<all_features>;

nb::object closest(SceneHandle& scene, const Points& origins, const Points& directions,
                   const std::string& intersector) {
    require_same(origins.shape(0), directions.shape(0));
    const std::size_t n = origins.shape(0);
    std::vector<float> t(n);
    std::vector<float> b(2 * n);
    std::vector<u32> primitive(n);
    const SceneView<float> view = scene.host().view();
    const ImageIntersector<Watertight, EveryFeature> ours(view);
    const EmbreeScene* embree = intersector == "embree" ? &scene.embree() : nullptr;
    for (std::size_t i = 0; i < n; ++i) {
        const Ray<float> ray = bare_ray(point(origins, i), point(directions, i));
        const Hit<float> hit = embree != nullptr ? embree->closest(ray) : ours.closest(ray);
        t[i] = hit.t;
        b[2 * i] = hit.b1;
        b[2 * i + 1] = hit.b2;
        primitive[i] = hit.primitive;
    }
    return nb::make_tuple(to_numpy(std::move(t), {n}), to_numpy(std::move(b), {n, 2}),
                          to_numpy(std::move(primitive), {n}));
}

nb::object occluded(SceneHandle& scene, const Points& origins, const Points& directions,
                    float t_max, u32 owner, const std::string& intersector) {
    require_same(origins.shape(0), directions.shape(0));
    const std::size_t n = origins.shape(0);
    std::vector<u8> blocked(n);
    const SceneView<float> view = scene.host().view();
    const ImageIntersector<Watertight, EveryFeature> ours(view);
    const EmbreeScene* embree = intersector == "embree" ? &scene.embree() : nullptr;
    for (std::size_t i = 0; i < n; ++i) {
        ShadowRay<float> ray{};
        ray.origin = point(origins, i);
        ray.direction = point(directions, i);
        ray.t_max = t_max;
        ray.owner = owner;
        blocked[i] = embree != nullptr ? embree->occluded(ray) : ours.occluded(ray);
    }
    return to_numpy(std::move(blocked), {n});
}

/// Points just hit, and where rays spawned there towards `next` start.
nb::object spawn(SceneHandle& scene, const Points& origins, const Points& directions,
                 const Points& next) {
    require_same(origins.shape(0), directions.shape(0));
    require_same(origins.shape(0), next.shape(0));
    const SceneView<float> view = scene.host().view();
    const ImageIntersector<Watertight, EveryFeature> intersector(view);
    std::vector<Vec3f> points;
    std::vector<Vec3f> normals;
    std::vector<Vec3f> starts;
    for (std::size_t i = 0; i < origins.shape(0); ++i) {
        const Ray<float> ray = bare_ray(point(origins, i), point(directions, i));
        const Hit<float> hit = intersector.closest(ray);
        if (!hit.found()) throw std::invalid_argument("ray " + std::to_string(i) + " hits nothing");
        const Surface<float> surface = surface_at<EveryFeature>(view, ray, hit);
        points.push_back(surface.point);
        normals.push_back(surface.geometric_normal);
        starts.push_back(Watertight::Offset::apply(surface.point, surface.geometric_normal,
                                                   surface.scale, point(next, i)));
    }
    return nb::make_tuple(points_to_numpy(points), points_to_numpy(normals),
                          points_to_numpy(starts));
}

nb::object bsdf_sample(const Material<float>& material, const std::array<float, 3>& view,
                       const Points& numbers) {
    const PhongBsdf<EveryFeature, float> bsdf(material, {0, 0, 1}, {view[0], view[1], view[2]});
    const std::size_t n = numbers.shape(0);
    std::vector<Vec3f> directions;
    std::vector<Vec3f> weights;
    std::vector<float> pdf(n);
    std::vector<u8> delta(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3f u = point(numbers, i);
        BsdfSample<float> sample = bsdf.sample(u.x, u.y, u.z);
        if (!sample.valid) sample = {{0, 0, 0}, {0, 0, 0}, 0, 1, false, false};
        directions.push_back(sample.direction);
        weights.push_back(sample.weight);
        pdf[i] = sample.pdf;
        delta[i] = sample.delta;
    }
    return nb::make_tuple(points_to_numpy(directions), points_to_numpy(weights),
                          to_numpy(std::move(pdf), {n}), to_numpy(std::move(delta), {n}));
}

nb::object bsdf_evaluate(const Material<float>& material, const std::array<float, 3>& view,
                         const Points& directions) {
    const PhongBsdf<EveryFeature, float> bsdf(material, {0, 0, 1}, {view[0], view[1], view[2]});
    std::vector<Vec3f> values;
    std::vector<float> pdf;
    for (std::size_t i = 0; i < directions.shape(0); ++i) {
        const BsdfValue<float> value = bsdf.evaluate(point(directions, i));
        values.push_back(value.value);
        pdf.push_back(value.pdf);
    }
    const std::size_t n = pdf.size();
    return nb::make_tuple(points_to_numpy(values), to_numpy(std::move(pdf), {n}));
}

/// The nodes of the compressed BVH as bytes, 80 each, and the primitives in the order of its
/// leaves.
nb::object bvh8_nodes(SceneHandle& scene) {
    const BuiltBvh8& built = scene.host().bvh8();
    const auto* bytes = reinterpret_cast<const u8*>(built.nodes.data());
    std::vector<u8> nodes(bytes, bytes + built.nodes.size() * sizeof(Bvh8Node));
    std::vector<u32> primitives;
    for (const PrimitiveRecord<float>& record : built.records) {
        primitives.push_back(record.primitive);
    }
    const std::size_t records = primitives.size();
    return nb::make_tuple(to_numpy(std::move(nodes), {built.nodes.size(), sizeof(Bvh8Node)}),
                          to_numpy(std::move(primitives), {records}));
}

nb::object lifo_need(u32 generations, u32 children) {
    return nb::int_(RayTree{generations, children}.lifo_need());
}

u64 most_rays(const std::array<u32, 2>& tree) { return RayTree{tree[0], tree[1]}.most_rays(); }

nb::object next_packet(const std::array<u32, 2>& tree, u64 capacity, u64 packet, u64 pending,
                       u64 unborn) {
    const Admission admission({tree[0], tree[1]}, capacity, packet);
    const PacketPlan plan = admission.next(pending, unborn);
    return nb::make_tuple(plan.pending, plan.born, plan.lifo);
}

/// Rays in the order in which a queue gives them out, as rows of pixel, sample and node, and its
/// peak in bytes. Every ray spawns all its children, up to the tree's generations.
nb::object drain_ray_queue(const std::array<u32, 2>& tree, const std::array<u32, 3>& samples,
                           u64 packet, u64 queue_bytes, bool lifo, u64 reserved) {
    Camera<float> camera{};
    camera.dx = {1, 0, 0};
    camera.dy = {0, 1, 0};
    camera.corner = {0, 0, 1};
    camera.width = samples[0];
    camera.height = samples[1];
    Schedule schedule;
    schedule.packet = u32(packet);
    schedule.queue_bytes = queue_bytes;
    schedule.order = lifo ? QueueOrder::lifo : QueueOrder::fifo;
    RayQueue queue(camera, {0, samples[2], 0}, {tree[0], tree[1]}, schedule);
    queue.reserve(reserved);
    std::vector<Ray<float>> rays(packet);
    std::vector<Ray<float>> children;
    std::vector<u64> order;
    while (const u64 size = queue.pop_packet(rays)) {
        children.clear();
        for (const Ray<float>& ray : std::span(rays).first(size)) {
            order.insert(order.end(), {ray.pixel, ray.sample, ray.node});
            if (u32(ray.layer) + 1 == tree[0]) continue;
            for (u32 slot = 0; slot < tree[1]; ++slot) {
                children.push_back(ray);
                ++children.back().layer;
                children.back().node = child_node(ray.node, slot);
            }
        }
        queue.push(children);
    }
    const std::size_t count = order.size() / 3;
    return nb::make_tuple(to_numpy(std::move(order), {count, 3}), queue.peak_bytes());
}

nb::object wavefront_room(const std::array<u32, 2>& tree, u64 bytes, u64 packet, u64 lanes,
                          u64 most_shadow_rays) {
    const auto room =
        cuda::WavefrontRoom::fit({tree[0], tree[1]}, bytes, packet, lanes, most_shadow_rays);
    return nb::make_tuple(room.lanes, room.packet, room.queue);
}

/// Rays in the order in which the queue of `wavefront` gives them out, by their node; the most that
/// were in it, with the packet; and how many were copied into gaps. Of a hundred rays above the
/// last generation so many as `fertile` spawn all their children, the others none.
nb::object drain_wavefront_queue(const std::array<u32, 2>& tree, u64 capacity, u64 packet,
                                 u64 samples, u32 fertile) {
    struct Waiting {
        u64 node;
        u32 generation;
    };
    const Admission admission({tree[0], tree[1]}, capacity, packet);
    const u32 size = u32(capacity + packet);
    std::vector<Waiting> ring(size);
    const auto at = [&](u32 place) -> Waiting& {
        return ring.at(place < size ? place : place - size);
    };
    std::vector<u64> order;
    u64 peak = 0;
    u64 moved = 0;
    WavefrontState state{};
    for (;;) {
        plan_packet(state, admission, samples, size);
        if (state.done) break;
        for (u32 i = state.pending; i < state.packet; ++i) {
            const u64 sample = state.next_camera_ray - (state.packet - i);
            at(state.packet_start + i) = {child_node(root_node, u32(sample)), 0};
        }
        for (u32 i = 0; i < state.packet; ++i) {
            const Waiting ray = at(state.packet_start + i);
            order.push_back(ray.node);
            if (ray.generation + 1 == tree[0] || ray.node % 100 >= fertile) continue;
            for (u32 slot = 0; slot < tree[1]; ++slot) {
                at(state.child_start + state.children++) = {child_node(ray.node, slot),
                                                            ray.generation + 1};
            }
        }
        peak = std::max<u64>(peak, u64(state.rest) + state.packet + state.children);
        const u32 filled = std::min(state.gap, state.children);
        for (u32 i = 0; i < filled; ++i) {
            at(state.packet_start + i) = at(state.child_start + (state.children - filled) + i);
        }
        moved += filled;
    }
    const std::size_t count = order.size();
    return nb::make_tuple(to_numpy(std::move(order), {count}), peak, moved);
}

nb::dict render_planted_reading(SceneHandle& scene, Settings<float> settings, u32 seed, u32 samples,
                                const std::string& reading, int threads) {
    settings.seed = seed;
    RenderOutput output;
    {
        const nb::gil_scoped_release release;
        output = render_planted(scene.host(), settings, samples, planted_reading(reading), threads);
    }
    return to_dict(std::move(output), scene.host().arrays().camera);
}

}  // namespace

void bind_testing(nb::module_& parent) {
    nb::module_ module = parent.def_submodule(
        "testing", "Pieces of the core, one call each, for the tests; nothing else uses them.");
    module.attr("ray_bytes") = sizeof(Ray<float>);
    module.def("philox", &philox, "counter"_a, "key"_a);
    module.def("sin_cos_of_turn", &sin_cos, "turns"_a);
    module.def("elementary", &elementary_values, "name"_a, "values"_a);
    module.def("warp", &warp_points, "name"_a, "numbers"_a, "parameter"_a = 0.0f);
    module.def("light_directions", &light_directions, "scene"_a, "light"_a, "origins"_a,
               "numbers"_a);
    module.def("convert", &convert, "values"_a, "exponent"_a, "rounding"_a);
    module.def("closest", &closest, "scene"_a, "origins"_a, "directions"_a,
               "intersector"_a = "haste");
    module.def("occluded", &occluded, "scene"_a, "origins"_a, "directions"_a, "t_max"_a = 1.0f,
               "owner"_a = no_shape, "intersector"_a = "haste");
    module.def("spawn", &spawn, "scene"_a, "origins"_a, "directions"_a, "next"_a);
    module.def("bsdf_sample", &bsdf_sample, "material"_a, "view"_a, "numbers"_a);
    module.def("bsdf_evaluate", &bsdf_evaluate, "material"_a, "view"_a, "directions"_a);
    module.def("bvh8_nodes", &bvh8_nodes, "scene"_a);
    module.def("lifo_need", &lifo_need, "generations"_a, "children"_a);
    module.def("most_rays", &most_rays, "tree"_a);
    module.def("next_packet", &next_packet, "tree"_a, "capacity"_a, "packet"_a, "pending"_a,
               "unborn"_a);
    module.def("drain_ray_queue", &drain_ray_queue, "tree"_a, "samples"_a, "packet"_a,
               "queue_bytes"_a, "lifo"_a, "reserved"_a = 0);
    module.def("drain_wavefront_queue", &drain_wavefront_queue, "tree"_a, "capacity"_a, "packet"_a,
               "samples"_a, "fertile"_a);
    module.def("wavefront_room", &wavefront_room, "tree"_a, "bytes"_a, "packet"_a, "lanes"_a,
               "most_shadow_rays"_a);
    module.def("render_planted", &render_planted_reading, "scene"_a, "settings"_a, nb::kw_only(),
               "seed"_a, "samples"_a, "reading"_a, "threads"_a = 0);
}

}  // namespace haste
