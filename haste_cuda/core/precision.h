#pragma once

#include "core/geometry/box.h"
#include "core/geometry/offset.h"

namespace haste {

// Of core/features/triangles.h: a type is named here, and made where there are triangles.
template <class Real>
struct WoopTest;

/// A precision mode: the real type, the triangle test, the padding of boxes and the offset of
/// spawned rays, in one type that is passed as a template parameter.
///
/// `Watertight` (the default): single precision, Woop's test with compensated edge functions, boxes
/// padded by what these tests may be off, offsets bounded by the error of the reconstruction.
struct Watertight {
    using Real = float;
    using TriangleTest = WoopTest<float>;
    using BoxTest = PaddedSlabTest<float>;
    using Offset = ErrorBoundedOffset<float>;
};

}  // namespace haste
