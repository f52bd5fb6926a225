#pragma once

#include "core/base/bvh8.h"
#include "core/geometry/box.h"

namespace haste {

/// A ray against the eight boxes of a compressed node: Ylitie, Karras and Laine, Efficient
/// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017, section 3.2, with the
/// slabs padded as `PaddedRay` says.
///
/// A plane is never decoded: with i the inverse direction and s the grid's step, byte q of a slab
/// lies at t = (plane_offset + q) (s i) + (origin - o) i. Beside the rounding that the padding
/// covers, the last product loses up to 2^-8 of a step there, half of `plane_margin`; s is a power
/// of two.
///
/// The GPU measures t in twice the `farthest` that any hit has, so that a slab's entry may be
/// clamped to [0, 1], which its multiplications do for nothing: no box is left beyond a half. It
/// does not look at t_min: boxes before it are visited in vain. Scaling costs three roundings more,
/// for which the padding has room.
struct Bvh8NodeTest {
    PaddedRay<float> ray;
    float unit;  ///< what t is multiplied by
    u32 octant;  ///< bit a: the ray does not go backwards along axis a

    HASTE_HD Bvh8NodeTest(const Vec3<float>& origin, const Vec3<float>& direction,
                          const Box& bounds)
        : ray(origin, direction, bounds),
          unit(1.0f),
          octant((ray.inverse.x < 0.0f ? 0u : 1u) | (ray.inverse.y < 0.0f ? 0u : 2u) |
                 (ray.inverse.z < 0.0f ? 0u : 4u)) {
        if constexpr (on_device) {
            unit = 0.5f / maximum(ray.farthest, Numeric<float>::least_distance);
            ray.inverse = ray.inverse * unit;
            ray.pad = ray.pad * unit;
        }
    }

    /// What the ray hits within (t_min, t_max], as if every slot held both an inner node and a leaf
    /// of three primitives: bit 24 + i and bits 3 i to 3 i + 2 for slot i.
    template <bool OnDevice = on_device>
    HASTE_HD u32 hits(const Bvh8Node& node, float t_min, float t_max) const {
        if constexpr (OnDevice) {
            return hits_slot_by_slot(node, t_max * unit);
        } else {
            return hits_side_by_side<EightFloats>(node, t_min, t_max);
        }
    }

    /// Moves bit i of eight to bit i ^ octant. The highest is then the slot to be visited first.
    HASTE_HD u32 in_order(u32 slots) const {
        if (octant & 1u) slots = ((slots << 1) & 0xaau) | ((slots >> 1) & 0x55u);
        if (octant & 2u) slots = ((slots << 2) & 0xccu) | ((slots >> 2) & 0x33u);
        if (octant & 4u) slots = ((slots << 4) & 0xf0u) | (slots >> 4);
        return slots;
    }

private:
    /// The slabs of an axis: t of byte q is (offset + q) step + near_base or + far_base, where
    /// `grid_origin` is the plane of -offset.
    struct Slabs {
        float step, near_base, far_base;

        HASTE_HD Slabs(float grid_origin, float grid_step, float origin, float inverse, float pad)
            : step(grid_step * inverse),
              near_base(fma(grid_origin - origin, inverse, -pad)),
              far_base(fma(grid_origin - origin, inverse, pad)) {}
    };

    /// For the GPU: the threads of a warp have a node each, so that this is about instructions.
    HASTE_HD u32 hits_slot_by_slot(const Bvh8Node& node, float end) const {
        const Slabs x(node.origin[0], node.step(0), ray.origin.x, ray.inverse.x, ray.pad.x);
        const Slabs y(node.origin[1], node.step(1), ray.origin.y, ray.inverse.y, ray.pad.y);
        const Slabs z(node.origin[2], node.step(2), ray.origin.z, ray.inverse.z, ray.pad.z);
        u32 near[3][2], far[3][2];
        for (int axis = 0; axis < 3; ++axis) {
            const bool forwards = octant & (1u << axis);
            for (int word = 0; word < 2; ++word) {
                near[axis][word] =
                    forwards ? node.planes[0][axis][word] : node.planes[1][axis][word];
                far[axis][word] =
                    forwards ? node.planes[1][axis][word] : node.planes[0][axis][word];
            }
        }
        const u32 offset = node.offset_bits;
        u32 hits = 0;
        add_slot<0>(offset, near, far, x, y, z, end, hits);
        add_slot<1>(offset, near, far, x, y, z, end, hits);
        add_slot<2>(offset, near, far, x, y, z, end, hits);
        add_slot<3>(offset, near, far, x, y, z, end, hits);
        add_slot<4>(offset, near, far, x, y, z, end, hits);
        add_slot<5>(offset, near, far, x, y, z, end, hits);
        add_slot<6>(offset, near, far, x, y, z, end, hits);
        add_slot<7>(offset, near, far, x, y, z, end, hits);
        return hits;
    }

    /// For the processor: eight slots at a time. The bytes are taken without the offset, for a
    /// product of the sum would be rounded here.
    template <class Floats>
    HASTE_HD u32 hits_side_by_side(const Bvh8Node& node, float t_min, float t_max) const {
        Floats near = Floats{} + t_min;
        Floats far = Floats{} + t_max;
        const auto clip = [&](int axis, float origin, float inverse, float pad) {
            const Slabs slabs(node.lowest_plane(axis), node.step(axis), origin, inverse, pad);
            const u32 forwards = (octant >> axis) & 1u;
            Floats entries, exits;
            eight_bytes(node.planes[1 - forwards][axis], entries);
            eight_bytes(node.planes[forwards][axis], exits);
            const Floats entry = entries * slabs.step + slabs.near_base;
            const Floats exit = exits * slabs.step + slabs.far_base;
            near = entry > near ? entry : near;
            far = exit < far ? exit : far;
        };
        clip(0, ray.origin.x, ray.inverse.x, ray.pad.x);
        clip(1, ray.origin.y, ray.inverse.y, ray.pad.y);
        clip(2, ray.origin.z, ray.inverse.z, ray.pad.z);
        const auto inside = near <= far;
        u32 hits = 0;
        for (u32 i = 0; i < 8; ++i) hits |= u32(inside[i]) & (1u << (24 + i) | 7u << (3 * i));
        return hits;
    }

    /// Floats that are not negative are in the order of their bits, and of two that are compared
    /// here one is not; the GPU has a minimum of three integers, and none of three floats.
    HASTE_HD static i32 bits(float x) { return i32(float_bits(x)); }

    /// plane_offset + q for byte `Byte` of a word: one permutation of bytes in place of a
    /// conversion, of which there are fewer units. The offset comes out of the node because an
    /// instruction has room for one constant, and that is the selector.
    template <int Byte>
    HASTE_HD static float plane(u32 word, u32 offset) {
        return bits_float(choose_bytes(word, offset, 0x7404u | (Byte << 4)));
    }

    template <int Slot>
    HASTE_HD static void add_slot(u32 offset, const u32 (&near)[3][2], const u32 (&far)[3][2],
                                  const Slabs& x, const Slabs& y, const Slabs& z, float end,
                                  u32& hits) {
        constexpr int word = Slot / 4;
        constexpr int byte = Slot % 4;
        const float near_x = saturate(fma(plane<byte>(near[0][word], offset), x.step, x.near_base));
        const float near_y = saturate(fma(plane<byte>(near[1][word], offset), y.step, y.near_base));
        const float near_z = saturate(fma(plane<byte>(near[2][word], offset), z.step, z.near_base));
        const float far_x = fma(plane<byte>(far[0][word], offset), x.step, x.far_base);
        const float far_y = fma(plane<byte>(far[1][word], offset), y.step, y.far_base);
        const float far_z = fma(plane<byte>(far[2][word], offset), z.step, z.far_base);
        const i32 far_z_or_end = minimum(bits(far_z), bits(end));
        const i32 enter = greatest_of_three(bits(near_x), bits(near_y), bits(near_z));
        const i32 leave = least_of_three(bits(far_x), bits(far_y), far_z_or_end);
        if (enter <= leave) hits |= (1u << (24 + Slot)) | (7u << (3 * Slot));
    }
};

}  // namespace haste
