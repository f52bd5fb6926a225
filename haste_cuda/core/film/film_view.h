#pragma once

#include "core/film/fixed_point.h"

namespace haste {

/// What went wrong with contributions: reported, never hidden.
struct FilmFaults {
    u64 non_finite = 0;
    /// Lowest pixel whose sum or contribution left the film's range.
    u32 overflow_pixel = 0xffffffffu;
};

/// The sum of one sample, or of one pixel of a tile, on its way to the film: integers in registers.
struct FilmSum {
    i64 channel[3] = {0, 0, 0};
    u32 non_finite = 0;
    bool overflow = false;

    /// Adds a contribution, each channel quantised on its own; overflow is detected before the add.
    template <class Real>
    HASTE_HD void add(const FixedPoint& format, const Vec3<Real>& value, u32 rounding) {
        const Real component[3] = {value.x, value.y, value.z};
        i64 units[3];
        u32 status = FixedPoint::fits;
        for (int c = 0; c < 3; ++c) {
            status |= format.convert(float(component[c]), rounding, units[c]);
        }
        if (status & FixedPoint::non_finite) {
            ++non_finite;
        } else if (status & FixedPoint::out_of_range) {
            overflow = true;
        } else {
            add(units);
        }
    }

    HASTE_HD void add(const i64 (&units)[3]) {
        for (int c = 0; c < 3; ++c) {
            if (channel[c] > max_sum - units[c]) {
                overflow = true;
            } else {
                channel[c] += units[c];
            }
        }
    }

    static constexpr i64 max_sum = 0x7fffffffffffffffll;
};

}  // namespace haste
