#pragma once

#include "core/base/settings.h"
#include "core/math/frame.h"
#include "core/model/shading_point.h"
#include "core/sampling/random.h"
#include "core/sampling/warp.h"

namespace haste {

/// `whitted`: the constant in the place of indirect light, equation 3.
template <class P, class Real>
HASTE_HD Vec3<Real> ambient_term(const ShadingPoint<P>& point, const Vec3<Real>& carried,
                                 const Settings<Real>& settings) {
    return carried * point.material.ambient * settings.ambient;
}

/// `haste`: equation 6: uniform directions about the normal, the plain mean of what they find.
/// Their random numbers are blocks of `random` from `first_block` on, their nodes the ray's
/// children from `first_slot` on.
template <class P, class Real, class Out>
HASTE_HD void spawn_ambient(const Ray<Real>& ray, const ShadingPoint<P>& point,
                            const RandomSource& random, u32 first_block, u32 first_slot,
                            u32 samples, bool cosine_weighted, Out& out) {
    if (is_zero(point.material.ambient)) return;
    const Frame<Real> frame = frame_about(point.normal);
    Ray<Real> next = ray;
    next.contribution = ray.contribution * point.material.ambient * (Real(1) / Real(samples));
    next.flags = single_bounce;
    for (u32 j = 0; j < samples; ++j) {
        const PhiloxBlock block = random.block(first_block + j);
        const Real u = uniform<Real>(block.word[0]);
        const Real v = uniform<Real>(block.word[1]);
        next.direction =
            frame.to_world(cosine_weighted ? cosine_hemisphere(u, v) : uniform_hemisphere(u, v));
        if (!(dot(next.direction, point.geometric_normal) > Real(0))) continue;
        next.origin = point.start(next.direction);
        next.node = child_node(ray.node, first_slot + j);
        out.child(next);
    }
}

}  // namespace haste
