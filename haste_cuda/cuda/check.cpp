#include "cuda/check.h"

#include <cstdio>
#include <exception>
#include <string_view>

namespace haste::cuda {

namespace {

/// The path from haste_cuda/ on: messages must not depend on where the source was compiled.
std::string_view short_path(std::string_view file) {
    const std::size_t at = file.rfind("haste_cuda/");
    return at == std::string_view::npos ? file : file.substr(at);
}

std::string error_text(CUresult result) {
    const char* name = nullptr;
    const char* meaning = nullptr;
    if (!driver_unavailable()) {
        driver().get_error_name(result, &name);
        driver().get_error_string(result, &meaning);
    }
    return std::string(name ? name : "unknown error") + " (" + std::to_string(result) + "), " +
           (meaning ? meaning : "no text");
}

}  // namespace

void throw_error(CUresult result, const char* expression, const char* file, int line,
                 const std::string& subject) {
    std::string message(short_path(file));
    message.append(":").append(std::to_string(line)).append(": ").append(expression);
    if (!subject.empty()) {
        message.append(" [").append(subject).append("]");
    }
    throw CudaError(message.append(": ").append(error_text(result)));
}

void report(CUresult result, const char* expression) noexcept {
    if (result == cuda_success || result == cuda_error_deinitialized ||
        std::uncaught_exceptions() > 0) {
        return;
    }
    try {
        std::fprintf(stderr, "haste: %s: %s\n", expression, error_text(result).c_str());
    } catch (...) {
        std::fputs("haste: a CUDA call failed in a destructor\n", stderr);
    }
}

}  // namespace haste::cuda
