#include "core/model/path_model.h"
#include "cpu/pass.h"

namespace haste {

PassResult watertight_path_pass(const PassRequest& request) {
    return model_pass<PathModel>(request);
}

}  // namespace haste
