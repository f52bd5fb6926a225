#pragma once

#include "core/base/scene_view.h"
#include "core/base/settings.h"
#include "core/engine/ray_counts.h"
#include "core/film/film_view.h"
#include "core/sampling/sample_range.h"

namespace haste {

/// The film of a pass: 3 sums a pixel, layer after layer; of integers, or of floats.
struct FilmTarget {
    FixedPoint format;
    i64* sums;
    float* values;
    FilmFaults* faults;  ///< one
    /// All adds to a sum that are less come to no more than half of its range, so that one bit at
    /// the end tells whether it overflowed: only larger ones have to look at the sum.
    u64 looks_from;
};

/// What every kernel is given: read by the host that fills it and the device that runs it. All
/// pointers are the device's.
struct RenderParams {
    SceneView<float> scene;
    Settings<float> settings;
    SampleRange range;
    FilmTarget film;
    RayCounts* rays;  ///< one; written by counting kernels only
};

}  // namespace haste
