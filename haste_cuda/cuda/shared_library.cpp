#include "cuda/shared_library.h"

#include <dlfcn.h>

namespace haste::cuda {

std::optional<SharedLibrary> SharedLibrary::load(const std::string& path, std::string& reason) {
    if (void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
        return SharedLibrary(handle);
    }
    const char* message = dlerror();
    reason = message ? message : "cannot load " + path;
    return std::nullopt;
}

void* SharedLibrary::address(const char* name) const { return dlsym(handle_, name); }

}  // namespace haste::cuda
