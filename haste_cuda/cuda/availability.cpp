#include "cuda/availability.h"

#include "cuda/driver_api.h"
#include "cuda/nvrtc.h"

namespace haste::cuda {

std::optional<std::string> cuda_unavailable() {
    if (std::optional<std::string> reason = driver_unavailable()) {
        return reason;
    }
    return nvrtc_unavailable();
}

}  // namespace haste::cuda
