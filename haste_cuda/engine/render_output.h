#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "core/engine/ray_counts.h"
#include "engine/schedule_work.h"

namespace haste {

/// A finished render.
struct RenderOutput {
    std::vector<double> mean;  ///< height x width x 3, radiance averaged over the samples
    std::string film_sha256;   ///< of the integer films of all passes and their exponent; empty
                               ///< for a film of floats, whose bits depend on the order
    double seconds = 0;        ///< tracing alone
    RayCounts rays;
    u64 peak_queue_bytes = 0;
    ScheduleWork work;
    u64 non_finite = 0;  ///< contributions dropped because they were not finite
};

/// A contribution or a sum left the film's range.
class FilmOverflow : public std::overflow_error {
    using std::overflow_error::overflow_error;
};

}  // namespace haste
