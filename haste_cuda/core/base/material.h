#pragma once

#include "core/math/vec3.h"

namespace haste {

enum class MaterialKind : u32 { phong = 0, dielectric = 1 };

/// A surface: the paper's constants, or a smooth dielectric with exact Fresnel terms.
/// A diffuse surface is Phong without the rest; a perfect mirror is Phong with `reflection` 1.
template <class Real>
struct Material {
    Vec3<Real> diffuse;   ///< k_d i_d
    Vec3<Real> specular;  ///< k_s i_s
    Vec3<Real> ambient;   ///< k_a
    Real exponent;        ///< alpha
    Real reflection;      ///< R of the mirror ray, equation 9
    Real transmission;    ///< R of the refracted ray, equation 9
    Real ior;             ///< index inside over index outside
    MaterialKind kind;
    u32 twosided;  ///< `path`: reflects on both sides
};

}  // namespace haste
