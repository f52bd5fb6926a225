#pragma once

/// Embree 3 and 4 behind one spelling: they differ in where a query's context goes.

#if HASTE_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "core/config.h"

namespace haste {

#if HASTE_EMBREE_MAJOR >= 4
using EmbreeContext = RTCRayQueryContext;
#else
using EmbreeContext = RTCIntersectContext;
#endif

/// A query's context, which Embree hands on to filters and user geometry.
struct OwnerContext {
    EmbreeContext base;
    u32 owner;  ///< the shape that never blocks
};

inline void init_context(OwnerContext& context, u32 owner) {
#if HASTE_EMBREE_MAJOR >= 4
    rtcInitRayQueryContext(&context.base);
#else
    rtcInitIntersectContext(&context.base);
#endif
    context.owner = owner;
}

inline void embree_intersect(RTCScene scene, OwnerContext& context, RTCRayHit& query) {
#if HASTE_EMBREE_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context.base;
    rtcIntersect1(scene, &query, &arguments);
#else
    rtcIntersect1(scene, &context.base, &query);
#endif
}

inline void embree_occluded(RTCScene scene, OwnerContext& context, RTCRay& ray) {
#if HASTE_EMBREE_MAJOR >= 4
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context.base;
    rtcOccluded1(scene, &ray, &arguments);
#else
    rtcOccluded1(scene, &context.base, &ray);
#endif
}

/// The same of 8 or 16 rays a call; `valid` is -1 where a lane holds a ray, else 0.
inline void embree_intersect(const int* valid, RTCScene scene, OwnerContext& context,
                             RTCRayHit8& query) {
#if HASTE_EMBREE_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context.base;
    rtcIntersect8(valid, scene, &query, &arguments);
#else
    rtcIntersect8(valid, scene, &context.base, &query);
#endif
}

inline void embree_intersect(const int* valid, RTCScene scene, OwnerContext& context,
                             RTCRayHit16& query) {
#if HASTE_EMBREE_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context.base;
    rtcIntersect16(valid, scene, &query, &arguments);
#else
    rtcIntersect16(valid, scene, &context.base, &query);
#endif
}

inline void embree_occluded(const int* valid, RTCScene scene, OwnerContext& context,
                            RTCRay8& rays) {
#if HASTE_EMBREE_MAJOR >= 4
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context.base;
    rtcOccluded8(valid, scene, &rays, &arguments);
#else
    rtcOccluded8(valid, scene, &context.base, &rays);
#endif
}

inline void embree_occluded(const int* valid, RTCScene scene, OwnerContext& context,
                            RTCRay16& rays) {
#if HASTE_EMBREE_MAJOR >= 4
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context.base;
    rtcOccluded16(valid, scene, &rays, &arguments);
#else
    rtcOccluded16(valid, scene, &context.base, &rays);
#endif
}

}  // namespace haste
