#pragma once

#include "core/base/camera.h"
#include "core/base/ray.h"
#include "core/sampling/random.h"

namespace haste {

/// The camera ray of a sample: uniform in the pixel (box filter), from the near plane.
template <class Real>
HASTE_HD Ray<Real> camera_ray(const Camera<Real>& camera, u32 pixel, u32 sample, u32 seed) {
    const PhiloxBlock random = RandomSource{pixel, sample, camera_node, seed}.block(0);
    const Real x = Real(pixel % camera.width) + uniform<Real>(random.word[0]);
    const Real y = Real(pixel / camera.width) + uniform<Real>(random.word[1]);
    const Vec3<Real> direction = camera.corner + camera.dx * x + camera.dy * y;
    Ray<Real> ray;
    ray.origin = camera.origin + direction * camera.near_clip;
    ray.direction = normalize(direction);
    ray.contribution = splat(Real(1));
    ray.pixel = pixel;
    ray.sample = sample;
    ray.layer = 0;
    ray.flags = delta_bounce;
    ray.node = root_node;
    ray.pdf = Real(0);
    ray.eta = Real(1);
    return ray;
}

}  // namespace haste
