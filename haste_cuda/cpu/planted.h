#pragma once

#include <string>

#include "cpu/render.h"

namespace haste {

/// A reading of the paper chosen at run time: the wrong ones that the gates must catch.
struct PlantedReading {
    bool ambient_is_cosine_weighted = false;
    bool lights_are_sampled_on_the_surface = false;
    bool refraction_uses_the_unturned_normal = false;
    bool lights_block_themselves = false;
    bool glass_lets_shadow_rays_through = false;
    bool a_light_is_no_number = false;  ///< no reading: what a film must leave out and count
};

/// The reading of a name: a field of `PlantedReading`, or "none" for the paper's own.
/// Throws std::invalid_argument.
PlantedReading planted_reading(const std::string& name);

/// Renders the model `haste` depth-first with a planted reading: the negative control of the gates.
RenderOutput render_planted(const HostScene& scene, const Settings<float>& settings, u32 samples,
                            const PlantedReading& reading, int threads);

}  // namespace haste
