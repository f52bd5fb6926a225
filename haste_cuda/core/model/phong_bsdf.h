#pragma once

#include "core/base/features.h"
#include "core/base/material.h"
#include "core/model/scattering.h"

namespace haste {

/// The scattering of a surface in `path`: a diffuse lobe, the energy-conserving Phong lobe of
/// Lafortune and Willems (Using the Modified Phong Reflectance Model for Physically Based
/// Rendering, 1994), an ideal mirror and an ideal refraction, or a smooth dielectric. Sides follow
/// the shading normal; with transmission the delta lobes act from both sides, the others from the
/// front.
template <class F, class Real>
class PhongBsdf {
public:
    /// `normal`: the shading normal, unturned; `view`: unit, towards the viewer.
    HASTE_HD PhongBsdf(const Material<Real>& material, const Vec3<Real>& normal,
                       const Vec3<Real>& view)
        : material_(material), view_(view) {
        front_ = dot(normal, view) > Real(0);
        normal_ = front_ ? normal : -normal;
        reflects_ = front_;
        if constexpr (F::twosided) reflects_ = reflects_ || reflects_behind(material);
        if constexpr (F::transmission) transmits_ = transmits(material);
        bool dielectric = false;
        if constexpr (F::dielectric) dielectric = is_dielectric(material);
        transmits_ = transmits_ || dielectric;
        if constexpr (F::diffuse) {
            if (reflects_) diffuse_share_ = max_component(material.diffuse);
        }
        if constexpr (F::specular) {
            if (reflects_) specular_share_ = max_component(material.specular);
        }
        if constexpr (F::refraction) {
            if (transmits_) {
                eta_ = front_ ? Real(1) / material.ior : material.ior;
                refraction_ = refract(view_, normal_, eta_);
                refraction_share_ = material.transmission;
            }
        }
        if constexpr (F::mirror) {
            if (reflects_ || transmits_) mirror_share_ = mirrored_share(material);
        }
        if constexpr (F::dielectric) {
            if (dielectric) {
                mirror_share_ = fresnel_dielectric(refraction_, eta_);
                refraction_share_ = Real(1) - mirror_share_;
            }
        }
        if (dot(normal_, view) == Real(0)) {
            diffuse_share_ = specular_share_ = mirror_share_ = refraction_share_ = Real(0);
        }
        const Real total = diffuse_share_ + specular_share_ + mirror_share_ + refraction_share_;
        inverse_total_ = total > Real(0) ? Real(1) / total : Real(0);
    }

    /// Whether any lobe can match a sampled light.
    HASTE_HD bool has_smooth_lobe() const {
        return diffuse_share_ > Real(0) || specular_share_ > Real(0);
    }

    HASTE_HD BsdfValue<Real> evaluate(const Vec3<Real>& direction) const {
        const Real cosine = dot(normal_, direction);
        BsdfValue<Real> sum{splat(Real(0)), Real(0)};
        if (!reflects_ || !(cosine > Real(0))) return sum;
        if constexpr (F::diffuse) sum = diffuse_lobe(material_, diffuse_share_, cosine);
        if constexpr (F::specular) {
            if (specular_share_ > Real(0)) {
                const BsdfValue<Real> lobe =
                    specular_lobe(material_, specular_share_, view_, normal_, direction, cosine);
                sum.value += lobe.value;
                sum.pdf += lobe.pdf;
            }
        }
        return {sum.value, sum.pdf * inverse_total_};
    }

    /// Chooses a lobe by its share of the energy, then a direction.
    HASTE_HD BsdfSample<Real> sample(Real choice, Real u, Real v) const {
        BsdfSample<Real> result;
        result.eta = Real(1);
        result.valid = false;
        result.delta = false;
        if (inverse_total_ == Real(0)) return result;
        Real target = choice / inverse_total_;
        if constexpr (F::diffuse) {
            if (target < diffuse_share_) return smooth(diffuse_direction(normal_, u, v), result);
            target -= diffuse_share_;
        }
        if constexpr (F::specular) {
            if (target < specular_share_) {
                return smooth(specular_direction(material_, view_, normal_, u, v), result);
            }
            target -= specular_share_;
        }
        result.delta = true;
        result.pdf = Real(0);
        if constexpr (F::refraction) {
            if (transmits_ && (target >= mirror_share_ || mirror_share_ == Real(0))) {
                if (!refraction_.total && refraction_share_ != Real(0)) {
                    take_refracted(refraction_, eta_, inverse_total_, result);
                }
                return result;
            }
        }
        if constexpr (F::mirror || F::dielectric) {
            if (mirror_share_ > Real(0)) {
                result.direction = normalize(reflect(view_, normal_));
                result.weight = splat(Real(1) / inverse_total_);
                result.valid = true;
            }
        }
        return result;
    }

private:
    HASTE_HD BsdfSample<Real> smooth(const Vec3<Real>& direction, BsdfSample<Real> result) const {
        result.direction = direction;
        const BsdfValue<Real> f = evaluate(result.direction);
        result.pdf = f.pdf;
        result.valid = f.pdf > Real(0);
        if (result.valid) result.weight = f.value * (Real(1) / f.pdf);
        return result;
    }

    const Material<Real>& material_;
    Vec3<Real> view_, normal_;
    Refraction<Real> refraction_;
    Real eta_ = Real(1);
    Real diffuse_share_ = Real(0), specular_share_ = Real(0);
    Real mirror_share_ = Real(0), refraction_share_ = Real(0);
    Real inverse_total_;
    bool front_, reflects_;
    bool transmits_ = false;
};

}  // namespace haste
