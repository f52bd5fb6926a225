#pragma once

#include "core/math/vec3.h"

namespace haste {

/// Snell's law at one point.
template <class Real>
struct Refraction {
    Vec3<Real> direction{};
    Real cosine_incident = 0;
    Real cosine_transmitted = 0;
    bool total = false;  ///< total internal reflection: there is no direction
};

/// The value of the non-delta lobes times the cosine, and the density with which they are sampled.
template <class Real>
struct BsdfValue {
    Vec3<Real> value;
    Real pdf;
};

/// A sampled direction with its weight f cos / pdf.
template <class Real>
struct BsdfSample {
    Vec3<Real> direction;
    Vec3<Real> weight;
    Real pdf;  ///< of the non-delta lobes together; 0 for a delta lobe
    Real eta;  ///< index beyond over index before, 1 for reflection
    bool delta;
    bool valid;
};

}  // namespace haste
