#include "accel/scene_fp64.h"
#include "core/model/haste_model.h"
#include "core/model/path_model.h"
#include "cpu/pass.h"

namespace haste {

PassResult fp64_pass(ModelKind model, const PassRequest& request) {
    const auto& scene = *static_cast<const SceneFp64*>(request.scene_fp64);
    return depth_first_of<Fp64, PathModel, HasteModel, WhittedModel>(model, request, scene.view(),
                                                                     to_fp64(request.settings));
}

}  // namespace haste
