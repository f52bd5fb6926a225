// What CUDA C++ has and C++ has not, for kernels that g++ compiles: threads run one after another,
// each as a warp in which it is the only one at work. Included before a kernel's source.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#define __device__
#define __global__
#define __shared__
#define __noinline__ __attribute__((noinline))
#define __grid_constant__
#define __launch_bounds__(...)

struct Index3 {
    unsigned x = 0, y = 0, z = 0;
};
inline thread_local Index3 threadIdx, blockIdx, blockDim, gridDim;

struct alignas(16) uint4 {
    unsigned x, y, z, w;
};
struct alignas(16) float4 {
    float x, y, z, w;
};

using std::max;
using std::min;

inline unsigned __activemask() { return 1u << (threadIdx.x % 32); }
template <class T>
T __shfl_sync(unsigned, T value, int) {
    return value;
}
inline int __any_sync(unsigned, int predicate) { return predicate; }
inline unsigned __ballot_sync(unsigned, int predicate) { return predicate ? __activemask() : 0; }
inline void __syncwarp(unsigned = ~0u) {}
inline int __popc(unsigned x) { return __builtin_popcount(x); }
inline int __ffs(int x) { return __builtin_ffs(x); }
inline std::size_t __cvta_generic_to_shared(const void*) { return 0; }
template <class T>
T __ldg(const T* from) {
    return *from;
}
template <class T>
T __ldcs(const T* from) {
    return *from;
}
template <class T>
T atomicAdd(T* to, T value) {
    const T before = *to;
    *to += value;
    return before;
}
template <class T>
T atomicMin(T* to, T value) {
    const T before = *to;
    *to = std::min(before, value);
    return before;
}

/// Runs a kernel's threads, the last first: no result may rest on their order.
template <class Parameters>
void run_threads(void (*kernel)(Parameters), const void* parameters, unsigned blocks,
                 unsigned threads) {
    gridDim.x = blocks;
    blockDim.x = threads;
    for (unsigned b = blocks; b-- > 0;) {
        for (unsigned t = threads; t-- > 0;) {
            blockIdx.x = b;
            threadIdx.x = t;
            kernel(*static_cast<const Parameters*>(parameters));
        }
    }
}
