#pragma once

namespace haste {

/// How the paper is read where it leaves a choice (docs/lighting.md). `HasteModel` takes the
/// reading as a type, so that tests can plant a wrong one and see the gates catch it; here every
/// wrong reading is a constant `false` and compiles to nothing.
struct PaperReading {
    static constexpr bool ambient_is_cosine_weighted = false;
    static constexpr bool lights_are_sampled_on_the_surface = false;
    static constexpr bool refraction_uses_the_unturned_normal = false;
    static constexpr bool lights_block_themselves = false;
};

}  // namespace haste
