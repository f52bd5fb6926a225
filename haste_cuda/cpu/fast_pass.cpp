#include "core/model/haste_model.h"
#include "core/model/path_model.h"
#include "cpu/pass.h"

namespace haste {

PassResult fast_pass(ModelKind model, const PassRequest& request) {
    return depth_first_of<Fast, PathModel, HasteModel, WhittedModel>(model, request, request.view,
                                                                     request.settings);
}

}  // namespace haste
