#pragma once

#include "core/accel/traversal.h"
#include "core/features/all.h"
#include "core/precision.h"
#include "cpu/layers.h"
#include "cpu/packets.h"

namespace haste {

/// Runs one pass of a model on an intersector by the engine that the schedule names.
template <bool Count, class Model, class I>
PassResult run_engine(const PassRequest& request, const Model& model, const I& intersector) {
    switch (request.schedule.engine) {
        case EngineKind::packets:
            return packets_pass<Model, I, Count>(request, model, intersector);
        case EngineKind::layers:
            return layers_pass<Model, I, Count>(request, model, intersector);
        default:
            return depth_first_pass<Model, I, Count>(request, request.view.camera, model,
                                                     intersector);
    }
}

template <class Model, class I>
PassResult run_pass(const PassRequest& request, const Model& model, const I& intersector) {
    return request.schedule.count_rays ? run_engine<true>(request, model, intersector)
                                       : run_engine<false>(request, model, intersector);
}

/// On the CPU a scene's features are only {triangles, spheres, both}; the rest is decided at run
/// time.
inline constexpr u32 cpu_features = all_features & ~(feature_triangles | feature_spheres);

template <template <class, class> class Model, u32 Kinds>
PassResult run_pass_on_bvh2(const PassRequest& request) {
    using F = Features<cpu_features | Kinds>;
    const Model<Watertight, F> model(request.view, request.settings);
    const ImageIntersector<Watertight, F> intersector(request.view);
    return run_pass(request, model, intersector);
}

/// The pass of a model on our own BVH.
template <template <class, class> class Model>
PassResult model_pass(const PassRequest& request) {
    switch (request.features & (feature_triangles | feature_spheres)) {
        case feature_triangles:
            return run_pass_on_bvh2<Model, feature_triangles>(request);
        case feature_spheres:
            return run_pass_on_bvh2<Model, feature_spheres>(request);
        default:
            return run_pass_on_bvh2<Model, feature_triangles | feature_spheres>(request);
    }
}

/// A model's pass in another precision: depth first, all features decided at run time.
template <class P, template <class, class> class Model>
PassResult depth_first_of(const PassRequest& request, const SceneView<typename P::Real>& view,
                          const Settings<typename P::Real>& settings) {
    using F = Features<all_features>;
    const Model<P, F> model(view, settings);
    const ImageIntersector<P, F> intersector(view);
    return request.schedule.count_rays
               ? depth_first_pass<Model<P, F>, ImageIntersector<P, F>, true>(request, view.camera,
                                                                             model, intersector)
               : depth_first_pass<Model<P, F>, ImageIntersector<P, F>, false>(request, view.camera,
                                                                              model, intersector);
}

template <class P, template <class, class> class Path, template <class, class> class Haste,
          template <class, class> class Whitted>
PassResult depth_first_of(ModelKind model, const PassRequest& request,
                          const SceneView<typename P::Real>& view,
                          const Settings<typename P::Real>& settings) {
    switch (model) {
        case ModelKind::path:
            return depth_first_of<P, Path>(request, view, settings);
        case ModelKind::haste:
            return depth_first_of<P, Haste>(request, view, settings);
        default:
            return depth_first_of<P, Whitted>(request, view, settings);
    }
}

/// One translation unit each: `watertight_path.cpp` and so on, and reference/embree for Embree's.
PassResult watertight_path_pass(const PassRequest& request);
PassResult watertight_haste_pass(const PassRequest& request);
PassResult watertight_whitted_pass(const PassRequest& request);
PassResult fast_pass(ModelKind model, const PassRequest& request);
PassResult fp64_pass(ModelKind model, const PassRequest& request);
PassResult embree_pass(ModelKind model, const PassRequest& request);

}  // namespace haste
