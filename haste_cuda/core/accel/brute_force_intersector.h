#pragma once

#include "core/accel/ray_questions.h"
#include "core/accel/tally.h"
#include "core/base/scene_view.h"

namespace haste {

/// Tests every primitive of the scene in turn: no hierarchy, so no error of one.
/// Arvo and Kirk, A Survey of Ray Tracing Acceleration Techniques, in Glassner (ed.), An
/// Introduction to Ray Tracing, 1989, call it exhaustive ray tracing; all else must agree with it.
template <class P, class F, class T = NoTally>
class BruteForceIntersector : public RayQuestions<BruteForceIntersector<P, F, T>, P> {
public:
    using Real = typename P::Real;

    HASTE_HD explicit BruteForceIntersector(const SceneView<Real>& scene, T* tally = nullptr)
        : scene_(scene), tally_(tally) {}

    template <class Start, class Visit>
    HASTE_HD bool traverse(const Vec3<Real>& origin, const Vec3<Real>& direction, Start t_min,
                           Real t_max, Visit&& visit) const {
        const TriangleTestOf<P, F> triangle_test(origin, direction);
        const u32 count = scene_.triangle_count + scene_.sphere_count;
        for (u32 i = 0; i < count; ++i) {
            T::primitive(tally_);
            if (visit_primitive<P, F>(record(i), triangle_test, origin, direction, t_min, t_max,
                                      visit)) {
                return true;
            }
        }
        return false;
    }

private:
    HASTE_HD PrimitiveRecord<Real> record(u32 i) const {
        if (i < scene_.triangle_count) {
            const u32* corner = scene_.triangles + 3 * u64(i);
            return {scene_.vertices[corner[0]], scene_.vertices[corner[1]],
                    scene_.vertices[corner[2]], i,
                    scene_.triangle_shape[i],   0};
        }
        const u32 sphere = i - scene_.triangle_count;
        return {scene_.sphere_centre[sphere],
                {scene_.sphere_radius[sphere], 0, 0},
                {0, 0, 0},
                i,
                scene_.sphere_shape[sphere],
                1};
    }

    const SceneView<Real>& scene_;
    T* tally_;
};

}  // namespace haste
