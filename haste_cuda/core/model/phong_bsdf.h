#pragma once

#include "core/base/features.h"
#include "core/base/material.h"
#include "core/math/frame.h"
#include "core/model/optics.h"
#include "core/sampling/random.h"
#include "core/sampling/warp.h"

namespace haste {

/// The value of the non-delta lobes times the cosine, and the density with which they are sampled.
template <class Real>
struct BsdfValue {
    Vec3<Real> value;
    Real pdf;
};

/// A sampled direction with its weight f cos / pdf.
template <class Real>
struct BsdfSample {
    Vec3<Real> direction;
    Vec3<Real> weight;
    Real pdf;  ///< of the non-delta lobes together; 0 for a delta lobe
    Real eta;  ///< index beyond over index before, 1 for reflection
    bool delta;
    bool valid;
};

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
        const bool turned = F::twosided && material.twosided && !front_;
        normal_ = front_ ? normal : -normal;
        reflects_ = front_ || turned;
        transmits_ = (F::transmission && material.transmission > Real(0)) ||
                     (F::dielectric && material.kind == MaterialKind::dielectric);
        const bool cosine_is_zero = dot(normal_, view) == Real(0);
        diffuse_share_ = reflects_ ? max_component(material.diffuse) : Real(0);
        specular_share_ = F::specular && reflects_ ? max_component(material.specular) : Real(0);
        mirror_share_ = Real(0);
        refraction_share_ = Real(0);
        if constexpr (F::transmission || F::dielectric) {
            if (transmits_) {
                eta_ = front_ ? Real(1) / material.ior : material.ior;
                refraction_ = refract(view_, normal_, eta_);
                refraction_share_ = material.transmission;
            }
        }
        if (F::dielectric && material.kind == MaterialKind::dielectric) {
            mirror_share_ = fresnel_dielectric(refraction_, eta_);
            refraction_share_ = Real(1) - mirror_share_;
        } else if (F::mirror && (reflects_ || transmits_)) {
            mirror_share_ = material.reflection;
        }
        if (cosine_is_zero) {
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
        if (!reflects_ || !(cosine > Real(0))) return {splat(Real(0)), Real(0)};
        const Real inverse_pi = Real(1) / Numeric<Real>::pi;
        Vec3<Real> value = material_.diffuse * (cosine * inverse_pi);
        Real pdf = diffuse_share_ * cosine * inverse_pi;
        if constexpr (F::specular) {
            if (specular_share_ > Real(0)) {
                const Real power =
                    power_of_cosine(reflect(view_, normal_), direction, material_.exponent) *
                    (Real(0.5) * inverse_pi);
                value += material_.specular * ((material_.exponent + Real(2)) * power * cosine);
                pdf += specular_share_ * (material_.exponent + Real(1)) * power;
            }
        }
        return {value, pdf * inverse_total_};
    }

    /// Chooses a lobe by its share of the energy, then a direction.
    HASTE_HD BsdfSample<Real> sample(Real choice, Real u, Real v) const {
        BsdfSample<Real> result;
        result.eta = Real(1);
        result.valid = false;
        result.delta = false;
        if (inverse_total_ == Real(0)) return result;
        Real target = choice / inverse_total_;
        if (target < diffuse_share_) {
            return smooth(frame_about(normal_).to_world(cosine_hemisphere(u, v)), result);
        }
        target -= diffuse_share_;
        if constexpr (F::specular) {
            if (target < specular_share_) {
                const Frame<Real> lobe = frame_about(reflect(view_, normal_));
                return smooth(lobe.to_world(phong_lobe(u, v, material_.exponent)), result);
            }
            target -= specular_share_;
        }
        result.delta = true;
        result.pdf = Real(0);
        if constexpr (F::transmission || F::dielectric) {
            if (transmits_ && (target >= mirror_share_ || mirror_share_ == Real(0))) {
                if (refraction_.total || refraction_share_ == Real(0)) return result;
                result.direction = normalize(refraction_.direction);
                // Radiance is squeezed into, or spread out of, the denser side's smaller solid
                // angle. The share chosen with is material.transmission or 1 - F, so only that
                // factor stays.
                result.weight = splat(eta_ * eta_ / inverse_total_);
                result.eta = Real(1) / eta_;
                result.valid = true;
                return result;
            }
        }
        if (mirror_share_ > Real(0)) {
            result.direction = normalize(reflect(view_, normal_));
            result.weight = splat(Real(1) / inverse_total_);
            result.valid = true;
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
    Real diffuse_share_, specular_share_, mirror_share_, refraction_share_, inverse_total_;
    bool front_, reflects_, transmits_;
};

}  // namespace haste
