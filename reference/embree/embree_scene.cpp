#include "reference/embree/embree_scene.h"

#include <stdexcept>

#include "core/geometry/sphere.h"
#include "host/stopwatch.h"
#include "host/thread_limit.h"

namespace haste {

namespace {

u32 owner_of(const EmbreeContext* context) {
    return reinterpret_cast<const OwnerContext*>(context)->owner;
}

/// Filter of a light's geometry: the light that owns the sampled point never blocks it.
void ignore_owner(const RTCFilterFunctionNArguments* arguments) {
    if (RTCHitN_geomID(arguments->hit, arguments->N, 0) == owner_of(arguments->context)) {
        arguments->valid[0] = 0;
    }
}

void sphere_bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& scene = *static_cast<const SceneArrays*>(arguments->geometryUserPtr);
    const Vec3f c = scene.sphere_centre[arguments->primID];
    // One part in 2^22 covers the rounding of centre -+ radius.
    const float r = scene.sphere_radius[arguments->primID];
    const float padded = r + gamma_bound<float>(4) * (r + max_norm(c));
    *arguments->bounds_o = {c.x - padded, c.y - padded, c.z - padded, 0,
                            c.x + padded, c.y + padded, c.z + padded, 0};
}

PrimitiveHit<float> hit_sphere(const SceneArrays& scene, u32 sphere, const RTCRay& ray) {
    const PrimitiveHit<float> hit = intersect_sphere(
        Vec3f{ray.org_x, ray.org_y, ray.org_z}, Vec3f{ray.dir_x, ray.dir_y, ray.dir_z},
        scene.sphere_centre[sphere], scene.sphere_radius[sphere], ray.tnear);
    return {hit.t, 0, 0, hit.found && hit.t <= ray.tfar};
}

void intersect_spheres(const RTCIntersectFunctionNArguments* arguments) {
    if (!arguments->valid[0]) return;
    auto& query = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);
    const auto& scene = *static_cast<const SceneArrays*>(arguments->geometryUserPtr);
    const PrimitiveHit<float> hit = hit_sphere(scene, arguments->primID, query.ray);
    if (!hit.found) return;
    query.ray.tfar = hit.t;
    query.hit.u = query.hit.v = 0;
    query.hit.primID = arguments->primID;
    query.hit.geomID = arguments->geomID;
    query.hit.instID[0] = arguments->context->instID[0];
}

void occlude_spheres(const RTCOccludedFunctionNArguments* arguments) {
    if (!arguments->valid[0]) return;
    auto& ray = *reinterpret_cast<RTCRay*>(arguments->ray);
    const auto& scene = *static_cast<const SceneArrays*>(arguments->geometryUserPtr);
    if (scene.sphere_shape[arguments->primID] == owner_of(arguments->context)) return;
    const PrimitiveHit<float> hit = hit_sphere(scene, arguments->primID, ray);
    if (hit.found && hit.t < ray.tfar) ray.tfar = -Numeric<float>::infinity;
}

RTCRay make_ray(const Vec3f& origin, const Vec3f& direction, float t_min, float t_max) {
    return {origin.x,    origin.y, origin.z, t_min,       direction.x, direction.y,
            direction.z, 0.0f,     t_max,    0xffffffffu, 0,           0};
}

void count_bytes(void* user, ssize_t bytes) {
    *static_cast<std::size_t*>(user) += std::size_t(bytes);
}

}  // namespace

EmbreeScene::EmbreeScene(const HostScene& scene, int threads, EmbreeMode mode)
    : host_(scene), sphere_geometry_(u32(scene.arrays().shapes.size())) {
    const Stopwatch watch;
    const ThreadLimit limit(threads);
    // Eight children a node, vertices in the leaves: a sixth faster on a mesh than the four
    // children that Embree takes by itself in the robust mode; large pages on top of it gain
    // nothing. In the fast mode its own choice is eight-wide.
    const bool robust = mode == EmbreeMode::robust;
    device_.reset(rtcNewDevice(robust ? "tri_accel=bvh8.triangle4v" : nullptr));
    if (!device_) throw std::runtime_error("Embree cannot make a device");
    rtcSetDeviceMemoryMonitorFunction(
        device_.get(),
        [](void* user, ssize_t bytes, bool) {
            count_bytes(user, bytes);
            return true;
        },
        &bytes_);
    scene_.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(scene_.get(), robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
    for (u32 shape = 0; shape < scene.arrays().shapes.size(); ++shape) {
        if (!scene.arrays().shapes[shape].is_sphere) attach_mesh(shape);
    }
    if (has_spheres()) attach_spheres();
    rtcCommitScene(scene_.get());
    if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE) {
        throw std::runtime_error("Embree's build failed with error " + std::to_string(int(error)));
    }
    build_seconds_ = watch.seconds();
}

void EmbreeScene::attach_mesh(u32 index) {
    const SceneArrays& arrays = host_.arrays();
    const Shape& shape = arrays.shapes[index];
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    // Embree reads four floats at the last vertex: its own copy is padded.
    auto* vertices = static_cast<Vec3f*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                sizeof(Vec3f), 3 * std::size_t(shape.count)));
    auto* indices = static_cast<u32*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(u32), shape.count));
    if (vertices == nullptr || indices == nullptr) {
        throw std::runtime_error("Embree has no memory for a mesh");
    }
    for (u32 i = 0; i < 3 * shape.count; ++i) {
        vertices[i] = arrays.vertices[arrays.triangles[3 * std::size_t(shape.first) + i]];
        indices[i] = i;
    }
    if (shape.light != no_light) rtcSetGeometryOccludedFilterFunction(geometry, ignore_owner);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_.get(), geometry, index);
    rtcReleaseGeometry(geometry);
}

void EmbreeScene::attach_spheres() {
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, unsigned(host_.arrays().sphere_radius.size()));
    rtcSetGeometryUserData(geometry, const_cast<SceneArrays*>(&host_.arrays()));
    rtcSetGeometryBoundsFunction(geometry, sphere_bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect_spheres);
    rtcSetGeometryOccludedFunction(geometry, occlude_spheres);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_.get(), geometry, sphere_geometry_);
    rtcReleaseGeometry(geometry);
}

Hit<float> EmbreeScene::closest(const RTCRay& ray) const {
    OwnerContext context;
    init_context(context, no_shape);
    RTCRayHit query;
    query.ray = ray;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    embree_intersect(scene_.get(), context, query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return {query.ray.tfar, query.hit.u, query.hit.v,
            primitive(query.hit.geomID, query.hit.primID)};
}

u32 EmbreeScene::primitive(u32 geometry, u32 index) const {
    const SceneArrays& arrays = host_.arrays();
    return index + (geometry == sphere_geometry_ ? u32(arrays.triangle_shape.size())
                                                 : arrays.shapes[geometry].first);
}

bool EmbreeScene::traces_packets_of(int width) const {
    const RTCDeviceProperty native = width == 8 ? RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED
                                                : RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED;
    return rtcGetDeviceProperty(device_.get(), native) != 0;
}

bool EmbreeScene::occluded(RTCRay ray, u32 owner) const {
    OwnerContext context;
    init_context(context, owner);
    embree_occluded(scene_.get(), context, ray);
    return ray.tfar < 0.0f;
}

Hit<float> EmbreeScene::closest(const Ray<float>& ray) const {
    return closest(make_ray(ray.origin, ray.direction, 0.0f, Numeric<float>::infinity));
}

Hit<float> EmbreeScene::closest(const RayQuery<float>& query) const {
    return closest(make_ray(query.origin, query.direction, query.t_min, query.t_max));
}

bool EmbreeScene::occluded(const ShadowRay<float>& shadow) const {
    return occluded(make_ray(shadow.origin, shadow.direction, 0.0f, shadow.t_max), shadow.owner);
}

bool EmbreeScene::any_hit(const RayQuery<float>& query) const {
    return occluded(make_ray(query.origin, query.direction, query.t_min, query.t_max), no_shape);
}

std::string EmbreeScene::version() {
    const RTCDevice device = rtcNewDevice(nullptr);
    const auto part = [&](RTCDeviceProperty property) {
        return std::to_string(rtcGetDeviceProperty(device, property));
    };
    std::string version = part(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." +
                          part(RTC_DEVICE_PROPERTY_VERSION_MINOR) + "." +
                          part(RTC_DEVICE_PROPERTY_VERSION_PATCH);
    rtcReleaseDevice(device);
    return version;
}

}  // namespace haste
