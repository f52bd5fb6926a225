#pragma once

#include "core/math/vec3.h"

namespace haste {

/// Render settings: never properties of a scene.
template <class Real>
struct Settings {
    u32 max_depth;        ///< `path`: 1 = emission only, 2 = direct light
    u32 rr_depth;         ///< `path`: first depth at which Russian roulette may end a path
    u32 max_layers;       ///< `haste`, `whitted`: layers 0 .. max_layers - 1 are shaded
    u32 light_samples;    ///< `haste`: per light
    u32 ambient_samples;  ///< `haste`: per hit
    Vec3<Real> ambient;   ///< `whitted`: the constant that stands for indirect light
    Real clamp;           ///< `path`: most that a contribution of indirect light may sum to
    u32 seed;
};

}  // namespace haste
