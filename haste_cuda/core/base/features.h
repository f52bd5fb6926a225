#pragma once

#include "core/config.h"

namespace haste {

/// What a scene requires, and what settings ask for beyond it. A kernel is compiled for exactly
/// that. The code of each lies in core/features/, in the header of its name, which no program
/// includes that lacks the feature: docs/features.md.
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
    feature_diffuse = 1u << 13,
    feature_several_lights = 1u << 14,  ///< the environment counted
    feature_bounces = 1u << 15,         ///< also of the settings: rays of a further layer
};

inline constexpr u32 feature_count = 16;
inline constexpr u32 all_features = (1u << feature_count) - 1;

/// In the order of the bits; a header of core/features/ each.
inline constexpr const char* feature_names[feature_count] = {
    "triangles", "spheres",      "smooth_normals", "mesh_lights", "sphere_lights", "specular",
    "mirror",    "transmission", "dielectric",     "twosided",    "ambient",       "environment",
    "clamp",     "diffuse",      "several_lights", "bounces"};

/// The features as constants of a type, so that what a scene lacks compiles to nothing. Headers of
/// all programs call what a feature's header defines only where the constant is true, on arguments
/// of this namespace by which the compiler finds it once it is there.
template <u32 Mask>
struct Features {
    static constexpr u32 mask = Mask;
    static constexpr bool triangles = Mask & feature_triangles;
    static constexpr bool spheres = Mask & feature_spheres;
    static constexpr bool smooth_normals = Mask & feature_smooth_normals;
    static constexpr bool mesh_lights = Mask & feature_mesh_lights;
    static constexpr bool sphere_lights = Mask & feature_sphere_lights;
    static constexpr bool lights = mesh_lights || sphere_lights;
    static constexpr bool specular = Mask & feature_specular;
    static constexpr bool mirror = Mask & feature_mirror;
    static constexpr bool transmission = Mask & feature_transmission;
    static constexpr bool dielectric = Mask & feature_dielectric;
    static constexpr bool refraction = transmission || dielectric;
    static constexpr bool twosided = Mask & feature_twosided;
    static constexpr bool ambient = Mask & feature_ambient;
    static constexpr bool environment = Mask & feature_environment;
    static constexpr bool clamp = Mask & feature_clamp;
    static constexpr bool diffuse = Mask & feature_diffuse;
    static constexpr bool several_lights = Mask & feature_several_lights;
    static constexpr bool bounces = Mask & feature_bounces;
};

}  // namespace haste
