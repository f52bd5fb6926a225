#pragma once

#include "core/base/settings.h"
#include "core/geometry/surface.h"
#include "core/model/phong_bsdf.h"
#include "core/sampling/light_sample.h"
#include "core/sampling/random.h"

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
          emitter_count_(scene.light_count + (environment_shines() ? 1 : 0)) {}

    /// The ray left the scene: the environment shines, weighed against having sampled it as a
    /// light.
    template <class Out>
    HASTE_HD void miss(const Ray<Real>& ray, Out& out) const {
        if constexpr (F::environment) {
            if (!has_environment(scene_)) return;
            Real weight = Real(1);
            if (!(ray.flags & delta_bounce)) {
                const Real pdf = environment_pdf(scene_);
                weight = power_heuristic(ray.pdf, pdf / Real(emitter_count_));
            }
            out.radiance(ray,
                         clamped(ray.contribution * scene_.environment * weight, ray.layer > 1),
                         spare_bits(numbers(ray).block(scatter_block)));
        }
    }

    template <class Out>
    HASTE_HD void shade(const Ray<Real>& ray, const Hit<Real>& hit, Out& out) const {
        const Surface<Real> surface = surface_at<F>(scene_, ray, hit);
        const Shape& shape = scene_.shapes[surface.shape];
        const Vec3<Real> view = -ray.direction;
        const PhiloxBlock scatter = numbers(ray).block(scatter_block);

        if constexpr (F::lights) {
            if (shape.light != no_light && dot(surface.shading_normal, view) > Real(0)) {
                emission(ray, hit, surface, scene_.lights[shape.light], spare_bits(scatter), out);
            }
        }
        if (ray.layer + 1u >= settings_.max_depth) return;

        const PhongBsdf<F, Real> bsdf(scene_.materials[shape.material], surface.shading_normal,
                                      view);
        if constexpr (F::lights || F::environment) {
            if (bsdf.has_smooth_lobe() && emitter_count_ > 0) {
                sample_emitter(ray, surface, bsdf, out);
            }
        }
        if constexpr (F::bounces) {
            const BsdfSample<Real> sample =
                bsdf.sample(uniform<Real>(scatter.word[0]), uniform<Real>(scatter.word[1]),
                            uniform<Real>(scatter.word[2]));
            continue_path(P(), ray, surface, sample, settings_, scatter.word[3], out);
        }
    }

private:
    /// Dimensions of a vertex's random numbers: lobe, direction and roulette; emitter and its
    /// point.
    static constexpr u32 scatter_block = 0;
    static constexpr u32 emitter_block = 1;

    HASTE_HD bool environment_shines() const {
        if constexpr (F::environment) return has_environment(scene_);
        return false;
    }

    HASTE_HD RandomSource numbers(const Ray<Real>& ray) const {
        return {ray.pixel, ray.sample, ray.node, settings_.seed};
    }

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

    HASTE_HD Vec3<Real> clamped(const Vec3<Real>& value, bool indirect) const {
        if constexpr (F::clamp) {
            if (indirect) return clamp_sum(value, settings_.clamp);
        }
        return value;
    }

    template <class Out>
    HASTE_HD void sample_emitter(const Ray<Real>& ray, const Surface<Real>& surface,
                                 const PhongBsdf<F, Real>& bsdf, Out& out) const {
        const PhiloxBlock random = numbers(ray).block(emitter_block);
        const Real u = uniform<Real>(random.word[0]);
        const Real v = uniform<Real>(random.word[1]);
        u32 emitter = 0;
        if constexpr (F::several_lights) {
            emitter = choose_emitter(scene_, random.word[2], emitter_count_);
        }
        ShadowRay<Real> shadow;
        shadow.owner = no_shape;
        shadow.pixel = ray.pixel;
        shadow.rounding = spare_bits(random);
        Vec3<Real> direction{};
        Vec3<Real> radiance{};
        Real pdf = Real(1);
        if (F::lights && (!F::environment || emitter < scene_.light_count)) {
            if constexpr (F::lights) {
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
            }
        } else {
            if constexpr (F::environment) {
                direction = environment_direction(scene_, u, v);
                radiance = scene_.environment;
                pdf = environment_pdf(scene_);
                shadow.origin = start(surface, direction);
                shadow.direction = direction;
                shadow.t_max = Numeric<Real>::infinity;
            }
        }
        pdf = pdf / Real(emitter_count_);
        const BsdfValue<Real> f = bsdf.evaluate(direction);
        const Real weight = power_heuristic(pdf, f.pdf) / pdf;
        shadow.value = clamped(ray.contribution * f.value * radiance * weight, ray.layer > 0);
        if (!is_zero(shadow.value)) out.shadow(shadow);
    }

    HASTE_HD static Vec3<Real> start(const Surface<Real>& surface, const Vec3<Real>& direction) {
        return P::Offset::apply(surface.point, surface.geometric_normal, surface.scale, direction);
    }

    const SceneView<Real>& scene_;
    const Settings<Real>& settings_;
    u32 emitter_count_;
};

}  // namespace haste
