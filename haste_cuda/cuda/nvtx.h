#pragma once

namespace haste::cuda {

/// Names what the host does in its scope, for profilers that show NVTX ranges. The library is
/// looked for at run time; without it this does nothing.
class NvtxRange {
public:
    explicit NvtxRange(const char* name);
    ~NvtxRange();
    NvtxRange(const NvtxRange&) = delete;
    NvtxRange& operator=(const NvtxRange&) = delete;
};

}  // namespace haste::cuda
