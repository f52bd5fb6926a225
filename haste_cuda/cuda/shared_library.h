#pragma once

#include <optional>
#include <string>
#include <utility>

namespace haste::cuda {

/// A library that is looked for when it is needed. It stays loaded until the process ends, for the
/// driver and NVRTC keep threads and state of their own that do not survive unloading.
class SharedLibrary {
public:
    /// Loads `path` (a file, or a name that the dynamic linker searches). Empty if that fails;
    /// `reason` then says why.
    [[nodiscard]] static std::optional<SharedLibrary> load(const std::string& path,
                                                           std::string& reason);

    /// Sets `function` to the exported function `name`; false, and a null pointer, if there is
    /// none.
    template <class Result, class... Arguments>
    [[nodiscard]] bool find(const char* name, Result (*&function)(Arguments...)) const {
        function = reinterpret_cast<Result (*)(Arguments...)>(address(name));
        return function != nullptr;
    }

private:
    explicit SharedLibrary(void* handle) : handle_(handle) {}
    [[nodiscard]] void* address(const char* name) const;

    void* handle_;
};

}  // namespace haste::cuda
