#include "core/model/haste_model.h"
#include "core/model/path_model.h"
#include "core/precision.h"
#include "cpu/pass.h"
#include "reference/embree/embree_scene.h"

namespace haste {

namespace {

/// Every feature at run time: Embree's traversal does not depend on them.
template <template <class, class> class Model>
PassResult model_pass_on_embree(const PassRequest& request) {
    const Model<Watertight, Features<all_features>> model(request.view, request.settings);
    const auto& scene = *static_cast<const EmbreeScene*>(request.embree_scene);
    return request.schedule.count_rays ? depth_first_pass<decltype(model), EmbreeScene, true>(
                                             request, request.view.camera, model, scene)
                                       : depth_first_pass<decltype(model), EmbreeScene, false>(
                                             request, request.view.camera, model, scene);
}

}  // namespace

PassResult embree_pass(ModelKind model, const PassRequest& request) {
    switch (model) {
        case ModelKind::path:
            return model_pass_on_embree<PathModel>(request);
        case ModelKind::haste:
            return model_pass_on_embree<HasteModel>(request);
        default:
            return model_pass_on_embree<WhittedModel>(request);
    }
}

}  // namespace haste
