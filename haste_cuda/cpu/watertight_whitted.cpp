#include "core/model/haste_model.h"
#include "cpu/pass.h"

namespace haste {

PassResult watertight_whitted_pass(const PassRequest& request) {
    return model_pass<WhittedModel>(request);
}

}  // namespace haste
