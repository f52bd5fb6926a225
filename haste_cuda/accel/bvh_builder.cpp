#include "accel/bvh_builder.h"

#if HASTE_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>

#include "accel/sha256.h"
#include "host/stopwatch.h"
#include "host/thread_limit.h"

namespace haste {

namespace {

/// What the builder's callbacks allocate: an inner node, or a leaf where `count` > 0.
struct BuildNode {
    RTCBounds bounds[2];
    BuildNode* child[2];
    u32 count;
    u32 primitive[max_bvh2_leaf];
};

Box box_of(const RTCBounds& b) {
    return {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
}

/// Rounded outwards to single precision.
float down(double x) {
    const float f = float(x);
    return double(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

float up(double x) {
    const float f = float(x);
    return double(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

Box bounds_of(std::span<const RTCBuildPrimitive> primitives) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Box bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (const RTCBuildPrimitive& p : primitives) {
        const float lower[3] = {p.lower_x, p.lower_y, p.lower_z};
        const float upper[3] = {p.upper_x, p.upper_y, p.upper_z};
        for (int k = 0; k < 3; ++k) {
            bounds.lower[k] = std::min(bounds.lower[k], lower[k]);
            bounds.upper[k] = std::max(bounds.upper[k], upper[k]);
        }
    }
    return bounds;
}

class Builder {
public:
    Builder(const SceneArrays& arrays)
        : arrays_(arrays), triangles_(arrays.triangle_shape.size()) {}

    BuiltBvh build(int threads, const BuildQuality& quality) {
        const Stopwatch watch;
        const ThreadLimit limit(threads);
        const std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)> device(
            rtcNewDevice(nullptr), rtcReleaseDevice);
        if (!device) throw std::runtime_error("Embree cannot make a device");
        const std::unique_ptr<RTCBVHTy, decltype(&rtcReleaseBVH)> bvh(rtcNewBVH(device.get()),
                                                                      rtcReleaseBVH);
        std::vector<RTCBuildPrimitive> primitives = build_primitives();
        const std::size_t count = primitives.size();
        built_.bounds = bounds_of(primitives);
        primitives.resize(count + std::size_t(quality.most_splits * double(count)));

        RTCBuildArguments arguments = rtcDefaultBuildArguments();
        arguments.buildQuality = RTC_BUILD_QUALITY_HIGH;
        arguments.maxBranchingFactor = 2;
        arguments.maxDepth = max_bvh_depth;
        arguments.sahBlockSize = 1;
        arguments.minLeafSize = 1;
        arguments.maxLeafSize = quality.max_leaf;
        arguments.traversalCost = 1.0f;
        arguments.intersectionCost = 1.0f;
        arguments.bvh = bvh.get();
        arguments.primitives = primitives.data();
        arguments.primitiveCount = count;
        arguments.primitiveArrayCapacity = primitives.size();
        arguments.createNode = [](RTCThreadLocalAllocator allocator, unsigned, void*) -> void* {
            return new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), 16)) BuildNode{};
        };
        arguments.setNodeChildren = [](void* node, void** children, unsigned n, void*) {
            for (unsigned i = 0; i < n; ++i) {
                static_cast<BuildNode*>(node)->child[i] = static_cast<BuildNode*>(children[i]);
            }
        };
        arguments.setNodeBounds = [](void* node, const RTCBounds** bounds, unsigned n, void*) {
            for (unsigned i = 0; i < n; ++i) static_cast<BuildNode*>(node)->bounds[i] = *bounds[i];
        };
        arguments.createLeaf = [](RTCThreadLocalAllocator allocator,
                                  const RTCBuildPrimitive* leaf_primitives, std::size_t n,
                                  void*) -> void* {
            auto* leaf = new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), 16)) BuildNode{};
            leaf->count = u32(n);
            for (std::size_t i = 0; i < n; ++i) leaf->primitive[i] = leaf_primitives[i].primID;
            // Threads hand primitives over in any order; the leaf keeps one.
            std::sort(leaf->primitive, leaf->primitive + n);
            return leaf;
        };
        arguments.splitPrimitive = [](const RTCBuildPrimitive* primitive, unsigned dimension,
                                      float position, RTCBounds* left, RTCBounds* right,
                                      void* self) {
            static_cast<const Builder*>(self)->split(*primitive, dimension, position, *left,
                                                     *right);
        };
        arguments.userPtr = this;
        const auto* root = static_cast<const BuildNode*>(rtcBuildBVH(&arguments));
        if (root == nullptr) {
            throw std::runtime_error("Embree's builder failed with error " +
                                     std::to_string(int(rtcGetDeviceError(device.get()))));
        }
        lay_out(*root);
        return finish(watch.seconds());
    }

private:
    const Vec3f& vertex(u32 triangle, int corner) const {
        return arrays_.vertices[arrays_.triangles[3 * std::size_t(triangle) + corner]];
    }

    std::vector<RTCBuildPrimitive> build_primitives() const {
        const std::size_t spheres = arrays_.sphere_radius.size();
        std::vector<RTCBuildPrimitive> primitives(triangles_ + spheres);
        for (std::size_t i = 0; i < triangles_; ++i) {
            const Vec3f& a = vertex(u32(i), 0);
            const Vec3f& b = vertex(u32(i), 1);
            const Vec3f& c = vertex(u32(i), 2);
            primitives[i] = {std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}),
                             std::min({a.z, b.z, c.z}), 0,
                             std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}),
                             std::max({a.z, b.z, c.z}), u32(i)};
        }
        for (std::size_t i = 0; i < spheres; ++i) {
            const Vec3f& c = arrays_.sphere_centre[i];
            const double r = arrays_.sphere_radius[i];
            primitives[triangles_ + i] = {
                down(c.x - r), down(c.y - r), down(c.z - r), 0,
                up(c.x + r),   up(c.y + r),   up(c.z + r),   u32(triangles_ + i)};
        }
        return primitives;
    }

    /// Boxes of the two parts of a primitive, left and right of a plane: a triangle is clipped, in
    /// double precision and rounded outwards; a sphere keeps the box's halves.
    void split(const RTCBuildPrimitive& primitive, unsigned dimension, float position,
               RTCBounds& left, RTCBounds& right) const {
        const float lower[3] = {primitive.lower_x, primitive.lower_y, primitive.lower_z};
        const float upper[3] = {primitive.upper_x, primitive.upper_y, primitive.upper_z};
        float part_lower[2][3];
        float part_upper[2][3];
        for (int side = 0; side < 2; ++side) {
            std::copy(lower, lower + 3, part_lower[side]);
            std::copy(upper, upper + 3, part_upper[side]);
        }
        part_upper[0][dimension] = std::min(position, upper[dimension]);
        part_lower[1][dimension] = std::max(position, lower[dimension]);
        if (primitive.primID < triangles_) {
            clip(primitive.primID, dimension, position, part_lower, part_upper);
        }
        left = {part_lower[0][0], part_lower[0][1], part_lower[0][2], 0,
                part_upper[0][0], part_upper[0][1], part_upper[0][2], 0};
        right = {part_lower[1][0], part_lower[1][1], part_lower[1][2], 0,
                 part_upper[1][0], part_upper[1][1], part_upper[1][2], 0};
    }

    void clip(u32 triangle, unsigned dimension, float position, float (&part_lower)[2][3],
              float (&part_upper)[2][3]) const {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        double bound_lower[2][3];
        double bound_upper[2][3];
        for (int side = 0; side < 2; ++side) {
            std::fill_n(bound_lower[side], 3, infinity);
            std::fill_n(bound_upper[side], 3, -infinity);
        }
        const auto extend = [&](int side, const double (&p)[3]) {
            for (int k = 0; k < 3; ++k) {
                bound_lower[side][k] = std::min(bound_lower[side][k], p[k]);
                bound_upper[side][k] = std::max(bound_upper[side][k], p[k]);
            }
        };
        for (int corner = 0; corner < 3; ++corner) {
            const Vec3f& a = vertex(triangle, corner);
            const Vec3f& b = vertex(triangle, (corner + 1) % 3);
            const double p[3] = {a.x, a.y, a.z};
            const double q[3] = {b.x, b.y, b.z};
            if (p[dimension] <= position) extend(0, p);
            if (p[dimension] >= position) extend(1, p);
            const bool crosses = (p[dimension] < position && q[dimension] > position) ||
                                 (p[dimension] > position && q[dimension] < position);
            if (!crosses) continue;
            const double s = (position - p[dimension]) / (q[dimension] - p[dimension]);
            double crossing[3];
            for (int k = 0; k < 3; ++k) crossing[k] = p[k] + s * (q[k] - p[k]);
            crossing[dimension] = position;
            extend(0, crossing);
            extend(1, crossing);
        }
        for (int side = 0; side < 2; ++side) {
            for (int k = 0; k < 3; ++k) {
                // One float beyond the rounded crossing covers the crossing's own rounding error.
                const float low = std::nextafter(down(bound_lower[side][k]),
                                                 -std::numeric_limits<float>::infinity());
                const float high = std::nextafter(up(bound_upper[side][k]),
                                                  std::numeric_limits<float>::infinity());
                part_lower[side][k] = std::max(part_lower[side][k], low);
                part_upper[side][k] = std::min(part_upper[side][k], high);
            }
        }
    }

    PrimitiveRecord<float> record(u32 primitive) const {
        if (primitive < triangles_) {
            return {vertex(primitive, 0),
                    vertex(primitive, 1),
                    vertex(primitive, 2),
                    primitive,
                    arrays_.triangle_shape[primitive],
                    0};
        }
        const std::size_t sphere = primitive - triangles_;
        return {arrays_.sphere_centre[sphere],
                {arrays_.sphere_radius[sphere], 0, 0},
                {0, 0, 0},
                primitive,
                arrays_.sphere_shape[sphere],
                1};
    }

    void lay_out(const BuildNode& root) {
        if (root.count == 0) {
            lay_out_inner(root, 1, 0);
            return;
        }
        // A tree that is one leaf still begins with a node; its other box holds nothing.
        constexpr float infinity = std::numeric_limits<float>::infinity();
        Bvh2Node node{};
        node.box[0] = built_.bounds;
        node.box[1] = {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
        node.count[0] = root.count;
        node.count[1] = 1;
        add_leaf(root);
        built_.nodes.push_back(node);
        built_.parents.push_back(0);
        built_.info.depth = 1;
    }

    u32 lay_out_inner(const BuildNode& inner, u32 depth, u32 parent) {
        if (depth > max_bvh_depth) {
            throw std::runtime_error("the BVH is deeper than " + std::to_string(max_bvh_depth));
        }
        built_.info.depth = std::max(built_.info.depth, depth);
        const u32 index = u32(built_.nodes.size());
        built_.nodes.emplace_back();
        built_.parents.push_back(parent);
        Bvh2Node node{};
        for (u32 i = 0; i < 2; ++i) {
            const BuildNode& child = *inner.child[i];
            node.box[i] = box_of(inner.bounds[i]);
            node.count[i] = child.count;
            node.child[i] =
                child.count > 0 ? add_leaf(child) : lay_out_inner(child, depth + 1, 2 * index + i);
        }
        built_.nodes[index] = node;
        return index;
    }

    u32 add_leaf(const BuildNode& leaf) {
        const u32 first = u32(built_.records.size());
        for (u32 i = 0; i < leaf.count; ++i) built_.records.push_back(record(leaf.primitive[i]));
        return first;
    }

    BuiltBvh finish(double seconds) {
        Sha256 hash;
        hash.update(std::as_bytes(std::span(built_.nodes)));
        for (const PrimitiveRecord<float>& r : built_.records) {
            hash.update(std::as_bytes(std::span(&r.primitive, 1)));
        }
        built_.info.sha256 = hash.hex();
        built_.info.build_seconds = seconds;
        built_.info.nodes = built_.nodes.size();
        built_.info.records = built_.records.size();
        built_.info.bytes = built_.nodes.size() * sizeof(Bvh2Node) +
                            built_.records.size() * sizeof(PrimitiveRecord<float>);
        return std::move(built_);
    }

    const SceneArrays& arrays_;
    std::size_t triangles_;
    BuiltBvh built_;
};

}  // namespace

BuiltBvh build_bvh2(const SceneArrays& arrays, int threads, const BuildQuality& quality) {
    return Builder(arrays).build(threads, quality);
}

}  // namespace haste
