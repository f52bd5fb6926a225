#pragma once

#include "core/base/settings.h"
#include "core/model/paper_reading.h"
#include "core/model/scattering.h"
#include "core/model/shading_point.h"
#include "core/sampling/light_sample.h"
#include "core/sampling/random.h"

namespace haste {

/// The paper's lighting model, equations 1-7 and 9, and Whitted's, which differs from it by one
/// light sample at the centroid and a constant ambient term (equations 2 and 3). docs/lighting.md
/// settles what the paper leaves open.
///
/// A model shades a hit and traces nothing. `out` receives
///     out.radiance(ray, value, rounding)   light that reaches the film now
///     out.shadow(ray)                      light that reaches the film if nothing blocks it
///     out.child(ray)                       a ray still to be traced
template <class P, class F, bool Whitted, class Reading = PaperReading>
class PhongModel {
public:
    using Real = typename P::Real;

    /// Most children that a hit can have beside its ambient rays.
    static constexpr u32 max_children = 2;

    HASTE_HD PhongModel(const SceneView<Real>& scene, const Settings<Real>& settings,
                        const Reading& reading = {})
        : scene_(scene), settings_(settings), reading_(reading) {}

    /// A ray that leaves the scene adds nothing.
    template <class Out>
    HASTE_HD void miss(const Ray<Real>&, Out&) const {}

    template <class Out>
    HASTE_HD void shade(const Ray<Real>& ray, const Hit<Real>& hit, Out& out) const {
        const Point point(scene_, ray, surface_at<F>(scene_, ray, hit));
        const RandomSource random{ray.pixel, ray.sample, ray.node, settings_.seed};
        if (ray.flags & single_bounce) {
            light_from_centroids(ray, point, random, 0, out);
            return;
        }
        if constexpr (F::lights) emission(ray, point, random, out);
        if constexpr (Whitted) {
            light_from_centroids(ray, point, random, 1, out);
            if constexpr (F::ambient) {
                out.radiance(ray, ambient_term(point, ray.contribution, settings_),
                             random.block(0).word[1]);
            }
        } else {
            light_from_samples(ray, point, random, out);
        }
        // Specular children before ambient ones: a stack then holds the ambient rays of one hit
        // only.
        if constexpr (F::bounces) {
            if (ray.layer + 1u < settings_.max_layers) specular_children(ray, point, out);
        }
        if constexpr (!Whitted && F::ambient) {
            const u32 first_block = 1 + scene_.light_count * settings_.light_samples;
            spawn_ambient(ray, point, random, first_block, max_children, settings_.ambient_samples,
                          reading_.ambient_is_cosine_weighted, out);
        }
    }

private:
    using Point = ShadingPoint<P>;

    /// Equation 7, on both sides.
    template <class Out>
    HASTE_HD void emission(const Ray<Real>& ray, const Point& point, const RandomSource& random,
                           Out& out) const {
        if (point.light == no_light) return;
        out.radiance(ray, ray.contribution * scene_.lights[point.light].radiance,
                     random.block(0).word[0]);
    }

    /// One term of equations 2-5: the light that reaches `point` from `target` on a light, times
    /// `factor`, if nothing lies between.
    template <class Out>
    HASTE_HD void light_from(const Ray<Real>& ray, const Point& point, const Light<Real>& light,
                             const Vec3<Real>& target, const Vec3<Real>& factor, u32 rounding,
                             Out& out) const {
        const Vec3<Real> offset = target - point.surface.point;
        const Real squared = length_squared(offset);
        if (!(squared > Real(0))) return;
        const Vec3<Real> l = offset * (Real(1) / square_root(squared));
        const Real cosine = dot(l, point.normal);
        if (!(cosine > Real(0)) || !(dot(l, point.geometric_normal) > Real(0))) return;
        Vec3<Real> reflected = splat(Real(0));
        if constexpr (F::diffuse) reflected = diffuse_term(point.material, cosine);
        if constexpr (F::specular) {
            reflected += specular_term(point.material, l, point.normal, point.view);
        }
        const Vec3<Real> value = factor * reflected * light.radiance;
        if (is_zero(value)) return;
        ShadowRay<Real> shadow;
        shadow.origin = point.start(l);
        shadow.direction = target - shadow.origin;
        shadow.t_max = Real(1);
        shadow.owner = reading_.lights_block_themselves ? no_shape : light.shape;
        shadow.value = value;
        shadow.pixel = ray.pixel;
        shadow.rounding = rounding;
        out.shadow(shadow);
    }

    /// Equations 2 and 3: one sample at the centroid of every light but the point's own.
    template <class Out>
    HASTE_HD void light_from_centroids(const Ray<Real>& ray, const Point& point,
                                       const RandomSource& random, u32 first_block,
                                       Out& out) const {
        visit_lights(point.light, [&](u32 i) {
            const Light<Real>& light = scene_.lights[i];
            light_from(ray, point, light, light.centroid, ray.contribution,
                       random.block(first_block + i).word[0], out);
        });
    }

    /// Equations 4 and 5: `light_samples` points in every light but the point's own.
    template <class Out>
    HASTE_HD void light_from_samples(const Ray<Real>& ray, const Point& point,
                                     const RandomSource& random, Out& out) const {
        const u32 samples = settings_.light_samples;
        const Vec3<Real> factor = ray.contribution * (Real(1) / Real(samples));
        visit_lights(point.light, [&](u32 i) {
            const Light<Real>& light = scene_.lights[i];
            for (u32 j = 0; j < samples; ++j) {
                const PhiloxBlock block = random.block(1 + i * samples + j);
                light_from(ray, point, light, point_in_light(light, block), factor, block.word[3],
                           out);
            }
        });
    }

    /// Calls visit(i) for every light but the point's own.
    template <class Visit>
    HASTE_HD void visit_lights(u32 own, Visit&& visit) const {
        if constexpr (F::several_lights) {
            visit_other_lights(scene_, own, visit);
        } else if constexpr (F::lights) {
            if (scene_.light_count == 1 && own != 0) visit(0u);
        }
    }

    /// In the volume of a sphere; by area on a mesh, which has none.
    HASTE_HD Vec3<Real> point_in_light(const Light<Real>& light, const PhiloxBlock& block) const {
        const Real u = uniform<Real>(block.word[0]);
        const Real v = uniform<Real>(block.word[1]);
        const Real w = uniform<Real>(block.word[2]);
        if (is_sphere_light<F>(light)) {
            if constexpr (F::sphere_lights) {
                return point_in_sphere_light(light, reading_.lights_are_sampled_on_the_surface, u,
                                             v, w);
            }
        }
        if constexpr (F::mesh_lights) return sample_mesh_light(scene_, light, w, u, v).point;
        return light.centroid;
    }

    /// Equation 9: mirror and refracted ray.
    template <class Out>
    HASTE_HD void specular_children(const Ray<Real>& ray, const Point& point, Out& out) const {
        const Material<Real>& material = point.material;
        Real reflection = Real(0);
        if constexpr (F::mirror) reflection = mirrored_share(material);
        if constexpr (F::refraction) {
            bool dielectric = false;
            bool refracts = false;
            if constexpr (F::transmission) refracts = transmits(material);
            if constexpr (F::dielectric) dielectric = is_dielectric(material);
            if (refracts || dielectric) {
                const Real eta = point.inside ? material.ior : Real(1) / material.ior;
                const Refraction<Real> refraction = refract(
                    point.view,
                    reading_.refraction_uses_the_unturned_normal ? point.surface.shading_normal
                                                                 : point.normal,
                    eta);
                Real transmission = material.transmission;
                if constexpr (F::dielectric) {
                    if (dielectric) {
                        reflection = fresnel_dielectric(refraction, eta);
                        transmission = Real(1) - reflection;
                    }
                }
                if (!refraction.total) {
                    spawn_bounce(ray, point, refraction.direction, transmission, 1, out);
                }
            }
        }
        if constexpr (F::mirror || F::dielectric) {
            spawn_bounce(ray, point, reflect(point.view, point.normal), reflection, 0, out);
        }
    }

    const SceneView<Real>& scene_;
    const Settings<Real>& settings_;
    Reading reading_;
};

/// Equations 1-7 and 9.
template <class P, class F>
using HasteModel = PhongModel<P, F, false>;

/// Whitted's: deterministic but for the position in the pixel.
template <class P, class F>
using WhittedModel = PhongModel<P, F, true>;

}  // namespace haste
