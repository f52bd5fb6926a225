#include "cuda/nvtx.h"

#include "cuda/shared_library.h"

namespace haste::cuda {

namespace {

struct Nvtx {
    int (*push)(const char* name) = nullptr;
    int (*pop)() = nullptr;
};

Nvtx load_nvtx() {
    Nvtx nvtx;
    std::string reason;
    const auto library = SharedLibrary::load("libnvToolsExt.so.1", reason);
    if (!library || !library->find("nvtxRangePushA", nvtx.push) ||
        !library->find("nvtxRangePop", nvtx.pop)) {
        return {};
    }
    return nvtx;
}

const Nvtx& nvtx() {
    static const Nvtx loaded = load_nvtx();
    return loaded;
}

}  // namespace

NvtxRange::NvtxRange(const char* name) {
    if (nvtx().push != nullptr) nvtx().push(name);
}

NvtxRange::~NvtxRange() {
    if (nvtx().pop != nullptr) nvtx().pop();
}

}  // namespace haste::cuda
