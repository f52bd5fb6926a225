#pragma once

#include "core/base/scene_view.h"
#include "core/base/settings.h"
#include "core/engine/ray_counts.h"
#include "core/film/film_view.h"

namespace haste {

/// What the depth-first kernel is given: read by the host that fills it and the device that runs
/// it. All pointers are the device's.
struct DepthFirstParams {
    SceneView<float> scene;
    Settings<float> settings;
    FixedPoint format;
    u32 first_sample;
    u32 samples;
    i64* sums;           ///< 3 a pixel
    FilmFaults* faults;  ///< one
    RayCounts* rays;     ///< one; written by counting kernels only

    /// Pixels are handed out in tiles of one warp, so that its rays start side by side.
    static constexpr u32 tile_width = 8;
    static constexpr u32 tile_height = 4;

    HASTE_HD u32 tiles_across() const { return (scene.camera.width + tile_width - 1) / tile_width; }
    HASTE_HD u32 tiles_down() const {
        return (scene.camera.height + tile_height - 1) / tile_height;
    }

    /// Threads to launch: one a sample of the image rounded up to whole tiles.
    HASTE_HD u64 items() const {
        return u64(tiles_across()) * tiles_down() * (tile_width * tile_height) * samples;
    }
};

}  // namespace haste
