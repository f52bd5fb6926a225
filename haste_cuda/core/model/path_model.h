#pragma once

#include "core/base/settings.h"
#include "core/geometry/surface.h"
#include "core/model/phong_bsdf.h"
#include "core/sampling/light_sample.h"

namespace haste {

/// The rendering equation, unbiased: unidirectional path tracing with one emitter chosen uniformly
/// at each vertex and multiple importance sampling by the power heuristic (Veach, Robust Monte
/// Carlo Methods for Light Transport Simulation, 1997, 9.2.4). Depth and sides mean what they mean
/// in Mitsuba's `path`, so that the two estimate the same integral.
template <class P, class F>
class PathModel {
public:
    using Real = typename P::Real;

    static constexpr u32 max_children = 1;

    HASTE_HD PathModel(const SceneView<Real>& scene, const Settings<Real>& settings)
        : scene_(scene),
          settings_(settings),
          emitter_count_(scene.light_count + (has_environment() ? 1 : 0)) {}

    /// The ray left the scene: the environment shines, weighed against having sampled it as a
    /// light.
    template <class Out>
    HASTE_HD void miss(const Ray<Real>& ray, Out& out) const {
        if (!has_environment()) return;
        Real weight = Real(1);
        if (!(ray.flags & delta_bounce)) {
            weight = power_heuristic(ray.pdf, uniform_sphere_pdf() / Real(emitter_count_));
        }
        out.radiance(ray, clamped(ray.contribution * scene_.environment * weight, ray.layer > 1),
                     spare_bits(numbers(ray).block(scatter_block)));
    }

    template <class Out>
    HASTE_HD void shade(const Ray<Real>& ray, const Hit<Real>& hit, Out& out) const {
        const Surface<Real> surface = surface_at<F>(scene_, ray, hit);
        const Shape& shape = scene_.shapes[surface.shape];
        const Vec3<Real> view = -ray.direction;
        const PhiloxBlock scatter = numbers(ray).block(scatter_block);

        if (shape.light != no_light && dot(surface.shading_normal, view) > Real(0)) {
            emission(ray, hit, surface, scene_.lights[shape.light], spare_bits(scatter), out);
        }
        if (ray.layer + 1u >= settings_.max_depth) return;

        const PhongBsdf<F, Real> bsdf(scene_.materials[shape.material], surface.shading_normal,
                                      view);
        if (bsdf.has_smooth_lobe() && emitter_count_ > 0) {
            sample_emitter(ray, surface, bsdf, out);
        }
        continue_path(ray, surface, bsdf, scatter, out);
    }

private:
    /// Dimensions of a vertex's random numbers: lobe, direction and roulette; emitter and its
    /// point.
    static constexpr u32 scatter_block = 0;
    static constexpr u32 emitter_block = 1;

    HASTE_HD bool has_environment() const { return F::environment && !is_zero(scene_.environment); }

    HASTE_HD RandomSource numbers(const Ray<Real>& ray) const {
        return {ray.pixel, ray.sample, ray.node, settings_.seed};
    }

    HASTE_HD static Real uniform_sphere_pdf() { return Real(1) / (Real(4) * Numeric<Real>::pi); }

    HASTE_HD static Real power_heuristic(Real pdf, Real other) {
        // By the ratio, which neither overflows nor loses the smaller one.
        const Real ratio = other / pdf;
        return Real(1) / (Real(1) + ratio * ratio);
    }

    template <class Out>
    HASTE_HD void emission(const Ray<Real>& ray, const Hit<Real>& hit, const Surface<Real>& surface,
                           const Light<Real>& light, u32 rounding, Out& out) const {
        Real weight = Real(1);
        if (!(ray.flags & delta_bounce)) {
            const Real pdf = light_direction_pdf<F>(light, ray.origin, ray.direction,
                                                    surface.geometric_normal, hit.t);
            weight = power_heuristic(ray.pdf, pdf / Real(emitter_count_));
        }
        out.radiance(ray, clamped(ray.contribution * light.radiance * weight, ray.layer > 1),
                     rounding);
    }

    /// A contribution scaled down to the sum of channels that the settings allow to light which has
    /// met two surfaces or more, as renderers do against fireflies (Cycles, `film_clamp_light`).
    HASTE_HD Vec3<Real> clamped(const Vec3<Real>& value, bool indirect) const {
        if (!F::clamp || !indirect) return value;
        const Real sum = value.x + value.y + value.z;
        return sum > settings_.clamp ? value * (settings_.clamp / sum) : value;
    }

    template <class Out>
    HASTE_HD void sample_emitter(const Ray<Real>& ray, const Surface<Real>& surface,
                                 const PhongBsdf<F, Real>& bsdf, Out& out) const {
        const PhiloxBlock random = numbers(ray).block(emitter_block);
        const Real u = uniform<Real>(random.word[0]);
        const Real v = uniform<Real>(random.word[1]);
        const u32 emitter = u32((u64(random.word[2] >> 8) * emitter_count_) >> 24);
        ShadowRay<Real> shadow;
        shadow.owner = no_shape;
        shadow.pixel = ray.pixel;
        shadow.rounding = spare_bits(random);
        Vec3<Real> direction;
        Vec3<Real> radiance;
        Real pdf;
        if (emitter < scene_.light_count) {
            const Light<Real>& light = scene_.lights[emitter];
            const LightDirection<Real> sample = sample_light_direction<F>(
                scene_, light, surface.point, uniform<Real>(random.word[3]), u, v);
            if (!sample.valid) return;
            direction = sample.direction;
            radiance = light.radiance;
            pdf = sample.pdf;
            shadow.origin = start(surface, direction);
            shadow.direction = P::Offset::apply(sample.target.point, sample.target.normal,
                                                sample.target.scale, -direction) -
                               shadow.origin;
            shadow.t_max = Real(1);
        } else {
            direction = uniform_sphere(u, v);
            radiance = scene_.environment;
            pdf = uniform_sphere_pdf();
            shadow.origin = start(surface, direction);
            shadow.direction = direction;
            shadow.t_max = Numeric<Real>::infinity;
        }
        pdf = pdf / Real(emitter_count_);
        const BsdfValue<Real> f = bsdf.evaluate(direction);
        const Real weight = power_heuristic(pdf, f.pdf) / pdf;
        shadow.value = clamped(ray.contribution * f.value * radiance * weight, ray.layer > 0);
        if (!is_zero(shadow.value)) out.shadow(shadow);
    }

    template <class Out>
    HASTE_HD void continue_path(const Ray<Real>& ray, const Surface<Real>& surface,
                                const PhongBsdf<F, Real>& bsdf, const PhiloxBlock& scatter,
                                Out& out) const {
        const BsdfSample<Real> sample =
            bsdf.sample(uniform<Real>(scatter.word[0]), uniform<Real>(scatter.word[1]),
                        uniform<Real>(scatter.word[2]));
        if (!sample.valid) return;
        Ray<Real> next = ray;
        next.contribution = ray.contribution * sample.weight;
        next.eta = ray.eta * sample.eta;
        const Real throughput = max_component(next.contribution);
        if (!(throughput > Real(0))) return;
        if (ray.layer + 1u >= settings_.rr_depth) {
            // The index squared keeps paths inside glass, whose radiance is scaled, as likely to
            // live.
            const Real survival = minimum(throughput * next.eta * next.eta, Real(0.95));
            if (!(uniform<Real>(scatter.word[3]) < survival)) return;
            next.contribution = next.contribution * (Real(1) / survival);
        }
        next.direction = sample.direction;
        next.origin = start(surface, sample.direction);
        next.layer = u16(ray.layer + 1);
        next.flags = u16(sample.delta ? delta_bounce : 0);
        next.node = child_node(ray.node, 0);
        next.pdf = sample.pdf;
        out.child(next);
    }

    HASTE_HD static Vec3<Real> start(const Surface<Real>& surface, const Vec3<Real>& direction) {
        return P::Offset::apply(surface.point, surface.geometric_normal, surface.scale, direction);
    }

    const SceneView<Real>& scene_;
    const Settings<Real>& settings_;
    u32 emitter_count_;
};

}  // namespace haste
