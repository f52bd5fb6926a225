#pragma once

#include <cstddef>

namespace haste::cuda {

/// Bytes a second between host and device, and within device memory.
struct CopyRates {
    double pinned_up = 0;  ///< from page-locked memory, nothing else under way
    double pinned_down = 0;
    double pinned_both = 0;  ///< each way, while as much goes the other way
    double pageable_up = 0;  ///< from ordinary memory
    double pageable_down = 0;
    double device = 0;  ///< read and written, both counted
};

/// Measures copies of so many bytes, the fastest of `repeats`. What a queue of rays on the host, or
/// in device memory, cannot beat. Throws CudaError, and std::invalid_argument without bytes.
[[nodiscard]] CopyRates measure_copies(std::size_t bytes, int repeats);

}  // namespace haste::cuda
