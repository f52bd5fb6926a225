#pragma once

#include "core/base/intersector.h"

namespace haste {

/// What is asked of every ray of a replay.
enum class QueryKind : u32 { closest, any_hit };

/// Answers one query: all that a replay does with a ray.
template <QueryKind Kind, class I, class Real>
    requires QueryIntersector<I, Real>
HASTE_HD QueryHit<Real> answer(const I& intersector, const RayQuery<Real>& query) {
    if constexpr (Kind == QueryKind::any_hit) {
        const bool found = intersector.any_hit(query);
        return {found ? Real(0) : Numeric<Real>::infinity, no_primitive};
    } else {
        const Hit<Real> hit = intersector.closest(query);
        return {hit.t, hit.primitive};
    }
}

}  // namespace haste
