#pragma once

#include "core/math/vec3.h"

namespace haste {

/// What a ray of the queue is for. The paper's listing 2 has one bit, `unibounce`; `path` needs
/// two.
enum RayFlags : u16 {
    /// The paper's single-bounce (ambient) ray: it shades what it hits and spawns no ray but
    /// shadows.
    single_bounce = 1,
    /// `path`: the last bounce followed a delta lobe, which no light sample can match.
    delta_bounce = 2,
};

/// The stateful ray: the paper's listing 2 plus what frees the image from the schedule.
/// `sample` and `node` name the ray in the image (and key its random numbers), whatever thread,
/// packet or order brings it to the intersector.
template <class Real>
struct alignas(16) Ray {
    Vec3<Real> origin;
    Vec3<Real> direction;  ///< unit length
    Vec3<Real>
        contribution;  ///< the factor C of equation 9, per channel: W/(sr m^2) released per unit
    u32 pixel;         ///< y * width + x
    u32 sample;
    u16 layer;  ///< 0 for camera rays; counts mirror, refraction and path bounces
    u16 flags;
    u64 node;  ///< in the sample's ray tree: child = child_node(parent, slot)
    Real pdf;  ///< `path`: density of the last bounce per solid angle, for multiple importance
               ///< sampling
    Real eta;  ///< `path`: product of the relative indices crossed, for Russian roulette
};

static_assert(sizeof(Ray<float>) == 64, "two rays to a 128-byte line, 16-byte loads");

/// For layers that are weighted afterwards (equation 8): a child of the next layer starts with a
/// contribution of 1. A single-bounce ray belongs to its parent's layer and keeps its own.
template <class Real>
HASTE_HD void drop_contribution(Ray<Real>& ray) {
    if (!(ray.flags & single_bounce)) ray.contribution = splat(Real(1));
}

/// A question of visibility and what an answer of `nothing in between` releases into the film.
template <class Real>
struct alignas(16) ShadowRay {
    Vec3<Real> origin;
    Vec3<Real> direction;  ///< from the origin to the target, not normalised
    Real t_max;            ///< 1 for a point, infinity for the environment
    u32 owner;             ///< the shape that never blocks, or `no_shape`
    Vec3<Real> value;
    u32 pixel;
    u32 rounding;  ///< random bits for the film's stochastic rounding
};

inline constexpr u32 no_shape = 0xffffffffu;

/// Node of the camera ray; node 0 holds the numbers of the camera sample itself.
inline constexpr u64 root_node = 1;
inline constexpr u64 camera_node = 0;

/// The child's node id: Stafford's variant 13 of the splitmix64 finaliser over (parent, slot).
HASTE_HD inline u64 child_node(u64 parent, u32 slot) {
    u64 z = parent * 0x9e3779b97f4a7c15ull + (u64(slot) + 1) * 0xd1342543de82ef95ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}

}  // namespace haste
