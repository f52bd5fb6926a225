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
    /// Units below which an add does not check the sum for overflow. All such adds of a pass come
    /// to less than 2^63, as does what larger ones were allowed to make of the sum, so that it
    /// cannot wrap around 2^64: its sign tells an overflow when the pass is done.
    u64 unchecked_below;
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
