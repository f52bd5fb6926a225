#pragma once

#include "core/config.h"

namespace haste {

/// What a scene requires, and settings beyond it. A kernel is compiled for exactly that.
enum FeatureBits : u32 {
    feature_triangles = 1u << 0,
    feature_spheres = 1u << 1,
    feature_smooth_normals = 1u << 2,
    feature_mesh_lights = 1u << 3,
    feature_sphere_lights = 1u << 4,
    feature_specular = 1u << 5,
    feature_mirror = 1u << 6,
    feature_transmission = 1u << 7,
    feature_dielectric = 1u << 8,
    feature_twosided = 1u << 9,
    feature_ambient = 1u << 10,
    feature_environment = 1u << 11,
    feature_clamp = 1u << 12,  ///< of the settings: indirect light is clamped
};

inline constexpr u32 all_features = (1u << 13) - 1;

/// The features as constants of a type, so that what a scene lacks compiles to nothing.
template <u32 Mask>
struct Features {
    static constexpr u32 mask = Mask;
    static constexpr bool triangles = Mask & feature_triangles;
    static constexpr bool spheres = Mask & feature_spheres;
    static constexpr bool smooth_normals = Mask & feature_smooth_normals;
    static constexpr bool mesh_lights = Mask & feature_mesh_lights;
    static constexpr bool sphere_lights = Mask & feature_sphere_lights;
    static constexpr bool specular = Mask & feature_specular;
    static constexpr bool mirror = Mask & feature_mirror;
    static constexpr bool transmission = Mask & feature_transmission;
    static constexpr bool dielectric = Mask & feature_dielectric;
    static constexpr bool twosided = Mask & feature_twosided;
    static constexpr bool ambient = Mask & feature_ambient;
    static constexpr bool environment = Mask & feature_environment;
    static constexpr bool clamp = Mask & feature_clamp;
};

}  // namespace haste
