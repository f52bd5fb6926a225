#pragma once

#include <optional>
#include <string>

namespace haste::cuda {

/// Why haste-cuda cannot run here, or nothing: a driver with a device is needed, and an NVRTC whose
/// programs it can load. Creates no context.
[[nodiscard]] std::optional<std::string> cuda_unavailable();

}  // namespace haste::cuda
