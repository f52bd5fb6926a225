#pragma once

#include "core/base/settings.h"
#include "core/geometry/surface.h"
#include "core/model/scattering.h"
#include "core/model/shading_point.h"
#include "core/sampling/random.h"

namespace haste {

/// `haste` and `whitted`: a ray of the next layer, which carries a share of its parent's light.
template <class P, class Real, class Out>
HASTE_HD void spawn_bounce(const Ray<Real>& ray, const ShadingPoint<P>& point,
                           const Vec3<Real>& direction, Real share, u32 slot, Out& out) {
    if (!(share > Real(0))) return;
    Ray<Real> next = ray;
    next.direction = normalize(direction);
    next.origin = point.start(next.direction);
    next.contribution = ray.contribution * share;
    next.layer = u16(ray.layer + 1);
    next.flags = 0;
    next.node = child_node(ray.node, slot);
    out.child(next);
}

/// `path`: the ray that goes on along a sampled direction, unless roulette ends the path.
template <class P, class Real, class Out>
HASTE_HD void continue_path(P, const Ray<Real>& ray, const Surface<Real>& surface,
                            const BsdfSample<Real>& sample, const Settings<Real>& settings,
                            u32 roulette_bits, Out& out) {
    if (!sample.valid) return;
    Ray<Real> next = ray;
    next.contribution = ray.contribution * sample.weight;
    next.eta = ray.eta * sample.eta;
    const Real throughput = max_component(next.contribution);
    if (!(throughput > Real(0))) return;
    if (ray.layer + 1u >= settings.rr_depth) {
        // The index squared keeps paths inside glass, whose radiance is scaled, as likely to live.
        const Real survival = minimum(throughput * next.eta * next.eta, Real(0.95));
        if (!(uniform<Real>(roulette_bits) < survival)) return;
        next.contribution = next.contribution * (Real(1) / survival);
    }
    next.direction = sample.direction;
    next.origin =
        P::Offset::apply(surface.point, surface.geometric_normal, surface.scale, sample.direction);
    next.layer = u16(ray.layer + 1);
    next.flags = u16(sample.delta ? delta_bounce : 0);
    next.node = child_node(ray.node, 0);
    next.pdf = sample.pdf;
    out.child(next);
}

}  // namespace haste
