#include "core/model/haste_model.h"
#include "cpu/pass.h"

namespace haste {

PassResult watertight_haste_pass(const PassRequest& request) {
    return model_pass<HasteModel>(request);
}

}  // namespace haste
