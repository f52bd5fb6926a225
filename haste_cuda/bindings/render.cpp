#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <map>
#include <optional>
#include <stdexcept>

#include "bindings/arrays.h"
#include "bindings/bindings.h"
#include "cpu/render.h"
#include "engine/requirements.h"
#include "engine/schedule.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace haste {

nb::dict to_dict(RenderOutput output, const Camera<float>& camera) {
    nb::dict result;
    result["film"] = to_numpy(std::move(output.mean), {camera.height, camera.width, 3});
    if (output.film_sha256.empty()) {
        result["film_sha256"] = nb::none();
    } else {
        result["film_sha256"] = output.film_sha256;
    }
    result["seconds"] = output.seconds;
    result["camera"] = output.rays.camera;
    result["shadow"] = output.rays.shadow;
    result["ambient"] = output.rays.ambient;
    result["bounce"] = output.rays.bounce;
    result["peak_queue_bytes"] = output.peak_queue_bytes;
    result["non_finite"] = output.non_finite;
    result["launches"] = output.work.launches;
    return result;
}

namespace {

/// The value of a name in a closed list. Throws std::invalid_argument naming the setting.
template <class Value>
Value choose(const char* setting, const std::string& name,
             const std::map<std::string, Value>& values) {
    if (const auto found = values.find(name); found != values.end()) return found->second;
    std::string known;
    for (const auto& [key, value] : values) known += (known.empty() ? "" : ", ") + key;
    throw std::invalid_argument(std::string(setting) + " must be one of " + known + ", not " +
                                name);
}

const char* kind_name(WorkKind kind) {
    switch (kind) {
        case WorkKind::pop:
            return "pop";
        case WorkKind::allocate:
            return "allocate";
        case WorkKind::upload:
            return "upload";
        case WorkKind::trace:
            return "trace";
        case WorkKind::download:
            return "download";
        default:
            return "push";
    }
}

nb::list to_list(const std::vector<WorkSpan>& spans) {
    nb::list list;
    for (const WorkSpan& span : spans) {
        list.append(
            nb::make_tuple(kind_name(span.kind), span.lane, span.begin, span.end, span.rays));
    }
    return list;
}

ModelKind model_kind(const std::string& name) {
    return choose<ModelKind>(
        "model", name,
        {{"path", ModelKind::path}, {"haste", ModelKind::haste}, {"whitted", ModelKind::whitted}});
}

Settings<float> make_settings(u32 max_depth, u32 rr_depth, u32 max_layers, u32 light_samples,
                              u32 ambient_samples, const std::array<float, 3>& ambient,
                              float clamp) {
    const Vec3<float> constant{ambient[0], ambient[1], ambient[2]};
    return {max_depth, rr_depth, max_layers, light_samples, ambient_samples, constant, clamp, 0};
}

const std::map<std::string, EngineKind> cuda_engines{
    {"depth_first", EngineKind::depth_first}, {"packets", EngineKind::packets},
    {"streams", EngineKind::streams},         {"layers", EngineKind::layers},
    {"wavefront", EngineKind::wavefront},     {"persistent", EngineKind::persistent}};

QueueOrder queue_order(const std::string& name) {
    return choose<QueueOrder>("order", name,
                              {{"fifo", QueueOrder::fifo}, {"lifo", QueueOrder::lifo}});
}

Accumulation accumulation_kind(const std::string& name) {
    return choose<Accumulation>(
        "accumulation", name,
        {{"flat", Accumulation::flat}, {"layer_weighted", Accumulation::layer_weighted}});
}

nb::dict render_on_cpu(SceneHandle& scene, const std::string& model, Settings<float> settings,
                       u32 seed, u32 samples, const std::string& engine,
                       const std::string& intersector, u64 packet, const std::string& order,
                       u64 queue_bytes, const std::string& accumulation,
                       const std::string& precision, u32 more_features, int threads,
                       bool count_rays, u32 pass_samples) {
    const ModelKind kind = model_kind(model);
    Schedule schedule;
    schedule.engine = choose<EngineKind>("engine", engine,
                                         {{"depth_first", EngineKind::depth_first},
                                          {"packets", EngineKind::packets},
                                          {"layers", EngineKind::layers}});
    schedule.intersector = choose<IntersectorKind>(
        "intersector", intersector,
        {{"haste", IntersectorKind::haste}, {"embree", IntersectorKind::embree}});
    if (schedule.intersector == IntersectorKind::embree &&
        schedule.engine != EngineKind::depth_first) {
        throw std::invalid_argument("the intersector embree runs with the engine depth_first only");
    }
    schedule.packet = packet;
    schedule.order = queue_order(order);
    schedule.queue_bytes = queue_bytes;
    schedule.accumulation = accumulation_kind(accumulation);
    schedule.precision = precision_of(precision);
    schedule.more_features = more_features;
    schedule.threads = threads;
    schedule.count_rays = count_rays;
    schedule.pass_samples = pass_samples;
    settings.seed = seed;
    RenderOutput output;
    {
        const nb::gil_scoped_release release;
        const void* embree =
            schedule.intersector == IntersectorKind::embree ? &scene.embree() : nullptr;
        output = render_cpu(scene.host(), kind, settings, samples, schedule, embree);
    }
    return to_dict(std::move(output), scene.host().arrays().camera);
}

nb::dict render_on_cuda(SceneHandle& scene, const std::string& model, Settings<float> settings,
                        u32 seed, u32 samples, const std::string& engine,
                        const std::optional<std::string>& traversal, u64 packet,
                        const std::string& order, const std::string& allocation, u64 queue_bytes,
                        u32 streams, const std::string& film, const std::string& accumulation,
                        const std::string& precision, u32 more_features, int block, bool count_rays,
                        bool record_spans, u32 pass_samples) {
    const ModelKind kind = model_kind(model);
    Schedule schedule;
    schedule.engine = choose<EngineKind>("engine", engine, cuda_engines);
    if (traversal) schedule.traversal = traversal_of(*traversal);
    schedule.packet = packet;
    schedule.order = queue_order(order);
    schedule.allocation =
        choose<Allocation>("allocation", allocation,
                           {{"per_packet", Allocation::per_packet}, {"once", Allocation::once}});
    schedule.queue_bytes = queue_bytes;
    schedule.streams = streams;
    schedule.film = choose<FilmKind>(
        "film", film, {{"int64", FilmKind::int64}, {"float_atomic", FilmKind::float_atomic}});
    schedule.accumulation = accumulation_kind(accumulation);
    schedule.precision = precision_of(precision);
    schedule.more_features = more_features;
    schedule.block = block;
    schedule.count_rays = count_rays;
    schedule.record_spans = record_spans;
    schedule.pass_samples = pass_samples;
    settings.seed = seed;
    cuda::CudaOutput output;
    {
        const nb::gil_scoped_release release;
        output = cuda::Renderer::instance().render(scene.host(), scene.device(), kind, settings,
                                                   samples, schedule);
    }
    const nb::list spans = to_list(output.render.work.spans);
    const u64 bytes_moved = output.render.work.bytes_moved;
    nb::dict result = to_dict(std::move(output.render), scene.host().arrays().camera);
    result["traversal"] = output.traversal;
    result["compile_seconds"] = output.compile_seconds;
    result["compile_cached"] = output.compile_cached;
    result["upload_seconds"] = output.upload_seconds;
    result["registers"] = output.registers;
    result["local_bytes"] = output.local_bytes;
    result["scene_bytes"] = output.scene_bytes;
    result["bytes_moved"] = bytes_moved;
    if (record_spans) result["spans"] = spans;
    return result;
}

}  // namespace

void bind_render(nb::module_& module) {
    constexpr u64 default_packet = Schedule{}.packet;
    constexpr u64 default_queue_bytes = Schedule{}.queue_bytes;
    // A GPU needs some hundred thousand rays to be full.
    constexpr u64 default_device_packet = u64(1) << 20;
    nb::exception<FilmOverflow>(module, "FilmOverflow", PyExc_OverflowError);
    nb::class_<Settings<float>>(module, "Settings", "Render settings: never properties of a scene.")
        .def(nb::new_(&make_settings), nb::kw_only(), "max_depth"_a = 8, "rr_depth"_a = 5,
             "max_layers"_a = 4, "light_samples"_a = 1, "ambient_samples"_a = 1,
             "ambient"_a = std::array<float, 3>{0.1f, 0.1f, 0.1f},
             "clamp"_a = Numeric<float>::infinity);
    module.def(
        "feature_names",
        [] { return std::vector<std::string>(feature_names, feature_names + feature_count); },
        "Names of the features, in the order of their bits.");
    module.def(
        "model_features",
        [](const std::string& model) { return model_features(model_kind(model)); }, "model"_a,
        "Bits of the features that a model has code for.");
    module.def(
        "required_features",
        [](SceneHandle& scene, const std::string& model, const Settings<float>& settings) {
            return required_features(scene.host().features(), model_kind(model), settings);
        },
        "scene"_a, "model"_a, "settings"_a, "Bits of the features that a render requires.");
    module.def(
        "stack_capacity",
        [](const std::string& model, const Settings<float>& settings, u32 features) {
            return stack_capacity(model_kind(model), settings, features);
        },
        "model"_a, "settings"_a, "features"_a,
        "Most rays that wait where a sample is traced depth first: what a kernel's stack holds.");
    module.def(
        "image_traversal",
        [](SceneHandle& scene, const std::string& engine) {
            const SceneArrays& arrays = scene.host().arrays();
            const u64 primitives = arrays.triangle_shape.size() + arrays.sphere_radius.size();
            return std::string(name_of(
                image_traversal(choose<EngineKind>("engine", engine, cuda_engines), primitives)));
        },
        "scene"_a, "engine"_a, "How an engine of the GPU finds what the rays of an image hit.");
    module.def(
        "ray_bytes", [] { return sizeof(Ray<float>); }, "Bytes of a ray that waits in a queue.");
    module.def("render_cpu", &render_on_cpu, "scene"_a, "model"_a, "settings"_a, nb::kw_only(),
               "seed"_a, "samples"_a, "engine"_a = "depth_first", "intersector"_a = "haste",
               "packet"_a = default_packet, "order"_a = "fifo",
               "queue_bytes"_a = default_queue_bytes, "accumulation"_a = "flat",
               "precision"_a = "watertight", "more_features"_a = 0u, "threads"_a = 0,
               "count_rays"_a = false, "pass_samples"_a = FixedPoint::max_pass_samples,
               "Renders on the CPU. Returns a dict: film (float64 [h, w, 3], mean radiance), "
               "film_sha256, seconds (tracing alone), rays by class (counted only if count_rays), "
               "peak_queue_bytes, non_finite, launches (packets, slices of layers, or passes). "
               "more_features: bits of features that the program has though nothing requires them, "
               "which changes no bit of the film. "
               "The precisions fast and fp64 are those of the engine depth_first alone. Raises "
               "ValueError on settings that make no sense and FilmOverflow naming the pixel.");
    module.def(
        "render_cuda", &render_on_cuda, "scene"_a, "model"_a, "settings"_a, nb::kw_only(), "seed"_a,
        "samples"_a, "engine"_a = "depth_first", "traversal"_a = nb::none(),
        "packet"_a = default_device_packet, "order"_a = "fifo", "allocation"_a = "once",
        "queue_bytes"_a = default_queue_bytes, "streams"_a = 3, "film"_a = "int64",
        "accumulation"_a = "flat", "precision"_a = "watertight", "more_features"_a = 0u,
        "block"_a = 128, "count_rays"_a = false, "record_spans"_a = false,
        "pass_samples"_a = FixedPoint::max_pass_samples,
        "Renders on the GPU. Returns the dict of render_cpu (film_sha256 is None for a film of "
        "floats; seconds are by the device's clock for depth_first, wavefront and persistent, by "
        "the host's for the others, whose host takes part) with traversal, compile_seconds, "
        "compile_cached, "
        "upload_seconds (of the kernels and the scene), registers, local_bytes (of the engine's "
        "main kernel), scene_bytes, bytes_moved (between host and device while tracing) and, with "
        "record_spans, spans: (kind, lane, begin, end, rays) "
        "of "
        "every copy, kernel and step of a queue on the host, in seconds from the beginning. Raises "
        "CudaError, ValueError and FilmOverflow.");
}

}  // namespace haste
