#pragma once

#include <stdexcept>
#include <string>

#include "cuda/driver_api.h"

namespace haste::cuda {

/// A failed call of the CUDA driver. The message names file, line, expression, the driver's name
/// for the error and its text.
class CudaError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Throws the CudaError of a failed call. `subject`, if there is one, says what the call was about:
/// the name of a kernel, the size of an allocation.
[[noreturn]] void throw_error(CUresult result, const char* expression, const char* file, int line,
                              const std::string& subject = {});

/// For destructors: reports a failure on standard error. Silent while an exception is in flight,
/// for after a kernel fault every later call fails with the same error.
void report(CUresult result, const char* expression) noexcept;

}  // namespace haste::cuda

/// Evaluates a call of the driver and throws CudaError with its place and text if it fails.
/// A second argument, evaluated on failure only, says what the call was about.
#define HASTE_CUDA_CHECK(call, ...)                                          \
    do {                                                                     \
        if (const ::haste::cuda::CUresult haste_cuda_result = (call);        \
            haste_cuda_result != ::haste::cuda::cuda_success) {              \
            ::haste::cuda::throw_error(haste_cuda_result, #call, __FILE__,   \
                                       __LINE__ __VA_OPT__(, ) __VA_ARGS__); \
        }                                                                    \
    } while (false)
