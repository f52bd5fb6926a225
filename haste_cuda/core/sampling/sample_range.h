#pragma once

#include "core/sampling/camera_ray.h"

namespace haste {

/// The camera rays of a pass, numbered: sample by sample, and within a sample in tiles of 8 x 4
/// pixels, so that the rays of a warp start side by side. Tiles at the border are cut, so every
/// number is a ray.
struct SampleRange {
    u32 first_sample;
    u32 samples;
    u32 seed;

    static constexpr u32 tile_width = 8;
    static constexpr u32 tile_height = 4;

    template <class Real>
    HASTE_HD u64 count(const Camera<Real>& camera) const {
        return u64(camera.width) * camera.height * samples;
    }

    /// The pixel at a place of the order, 0 .. width * height - 1.
    template <class Real>
    HASTE_HD static u32 pixel(const Camera<Real>& camera, u32 place) {
        const u32 band = place / (tile_height * camera.width);
        const u32 top = band * tile_height;
        const u32 rows = least(tile_height, camera.height - top);
        const u32 in_band = place - top * camera.width;
        const u32 left = in_band / (tile_width * rows) * tile_width;
        const u32 columns = least(tile_width, camera.width - left);
        const u32 in_tile = in_band - left * rows;
        return (top + in_tile / columns) * camera.width + left + in_tile % columns;
    }

    template <class Real>
    HASTE_HD Ray<Real> ray(const Camera<Real>& camera, u64 index) const {
        const u64 pixels = u64(camera.width) * camera.height;
        return camera_ray(camera, pixel(camera, u32(index % pixels)),
                          first_sample + u32(index / pixels), seed);
    }

private:
    HASTE_HD static u32 least(u32 a, u32 b) { return a < b ? a : b; }
};

}  // namespace haste
