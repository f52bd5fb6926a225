#pragma once

#include "core/base/ray.h"

namespace haste {

/// Shadow rays that wait, in arrays of what is read together: where a ray goes, which its tracing
/// reads, and what it releases, which is read where nothing blocks it.
struct ShadowList {
    struct alignas(16) Way {
        Vec3<float> origin;
        float t_max;
        Vec3<float> direction;
        u32 owner;
    };
    struct alignas(16) Light {
        Vec3<float> value;
        u32 pixel;
    };

    Way* ways;
    Light* lights;
    u32* roundings;

    static constexpr u64 ray_bytes = sizeof(Way) + sizeof(Light) + sizeof(u32);

    HASTE_HD void put(u32 place, const ShadowRay<float>& ray) const {
        ways[place] = {ray.origin, ray.t_max, ray.direction, ray.owner};
        lights[place] = {ray.value, ray.pixel};
        roundings[place] = ray.rounding;
    }

    HASTE_HD ShadowRay<float> get(u32 place) const {
        const Way way = ways[place];
        const Light light = lights[place];
        return {way.origin,  way.direction, way.t_max,       way.owner,
                light.value, light.pixel,   roundings[place]};
    }
};

static_assert(ShadowList::ray_bytes == 52, "12 less than a shadow ray, whose size is rounded up");

}  // namespace haste
