#pragma once

#include "core/math/numeric.h"

namespace haste {

/// Added to a plane's byte. In a float of this size the byte's place is a byte of its own, so that
/// one permutation of bytes makes the sum.
inline constexpr float plane_offset = 0x1p15f;

/// A node of the compressed BVH with eight children: Ylitie, Karras and Laine, Efficient
/// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017, section 2.
///
/// The planes of the children's boxes are bytes on a grid of the node's own: byte q of axis a is
/// the plane origin[a] + (plane_offset + q) 2^(e_a - 127). The builder places every plane
/// `plane_margin` of a grid step or more outside of the child's box, which is what the traversal's
/// arithmetic may lose.
///
/// In place of the paper's eight bytes of meta data there are two masks, so that a slot that is hit
/// adds a constant to what is to be done: slot i owns bit i of `inner` and bits 3 i to 3 i + 2 of
/// `primitives`, one a primitive of a leaf. Inner children and primitives are stored without gaps
/// in the order of their bits. An empty slot owns no set bit, so what its planes are is all one.
struct alignas(16) Bvh8Node {
    float origin[3];
    u32 frame;  ///< bytes 0 to 2: biased exponents e of the grid's steps; byte 3: `inner`
    u32 first_child;
    u32 first_primitive;
    u32 primitives;       ///< 24 bits
    u32 offset_bits;      ///< `plane_offset`, of which `Bvh8NodeTest` makes planes
    u32 planes[2][3][2];  ///< lower, upper; of each axis; slots 0 to 3, 4 to 7, a byte each

    HASTE_HD u32 inner() const { return frame >> 24; }
    /// The plane of byte 0; rounded.
    HASTE_HD float lowest_plane(int axis) const {
        return fma(plane_offset, step(axis), origin[axis]);
    }
    HASTE_HD float step(int axis) const {
        return bits_float(((frame >> (8 * axis)) & 0xffu) << 23);
    }
};

static_assert(sizeof(Bvh8Node) == 80, "five 16-byte loads");

inline constexpr u32 bvh8_width = 8;
inline constexpr u32 max_bvh8_leaf = 3;  ///< primitives

/// In steps of a node's grid: four roundings of `plane_offset`, of which the traversal loses two.
inline constexpr float plane_margin = 4.0f * Numeric<float>::unit_roundoff * plane_offset;
static_assert(128.0f * plane_margin == 1.0f);

/// Deepest tree that the traversal's stack can follow; the builder refuses a deeper one.
inline constexpr u32 max_bvh8_depth = 32;

}  // namespace haste
