#pragma once

#include "core/geometry/box.h"
#include "core/geometry/offset.h"
#include "core/geometry/plain_slabs.h"

namespace haste {

// Of core/features/triangles.h: types are named here, and made where there are triangles.
template <class Real>
struct WoopTest;
template <class Real>
struct MoellerTrumboreTest;

/// A precision mode: the real type, the triangle test, the padding of boxes and the offset of
/// spawned rays, in one type that is passed as a template parameter.
enum class PrecisionKind : u32 { watertight, fast, fp64 };

inline constexpr u32 precision_count = 3;
inline constexpr const char* precision_names[precision_count] = {"watertight", "fast", "fp64"};

HASTE_HD constexpr const char* name_of(PrecisionKind kind) { return precision_names[u32(kind)]; }

/// The default: single precision, Woop's test with compensated edge functions, boxes padded by what
/// these tests may be off, offsets bounded by the error of the reconstruction.
struct Watertight {
    using Real = float;
    using TriangleTest = WoopTest<float>;
    using BoxTest = PaddedSlabTest<float>;
    using Offset = ErrorBoundedOffset<float>;
};

/// What is common where speed is all: Möller and Trumbore's test and boxes without padding. On the
/// GPU it is compiled with fast arithmetic.
struct Fast {
    using Real = float;
    using TriangleTest = MoellerTrumboreTest<float>;
    using BoxTest = PlainSlabTest<float>;
    using Offset = ErrorBoundedOffset<float>;
};

/// `Watertight` in double precision, on the same scene in single precision: what it should have
/// found, but for the rounding of vertices.
struct Fp64 {
    using Real = double;
    using TriangleTest = WoopTest<double>;
    using BoxTest = PaddedSlabTest<double>;
    using Offset = ErrorBoundedOffset<double>;
};

}  // namespace haste
