#pragma once

#include <nanobind/nanobind.h>

namespace haste::cuda {

/// Adds what Python sees of CUDA: availability, the device, the compiler and its cache.
void bind_cuda(nanobind::module_& module);

}  // namespace haste::cuda
