#pragma once

/// The platform: the only file of the core that knows which compiler reads it.
/// g++ compiles the core for the CPU, NVRTC (and nvcc) for the GPU. NVRTC ships no standard
/// headers, so integer types and the handful of elementary functions that the core needs are named
/// here.

#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
#define HASTE_HD __host__ __device__
#else
#define HASTE_HD
#endif

#if !defined(__CUDACC_RTC__)
#include <cmath>
#endif

namespace haste {

using u8 = unsigned char;
using u16 = unsigned short;
using u32 = unsigned int;
using u64 = unsigned long long;
using i32 = int;
using i64 = long long;

static_assert(sizeof(u32) == 4 && sizeof(u64) == 8, "the film and Philox count on these widths");

/// IEEE operations: correctly rounded on both sides.
HASTE_HD inline float fma(float a, float b, float c) { return ::fmaf(a, b, c); }
HASTE_HD inline double fma(double a, double b, double c) { return ::fma(a, b, c); }
HASTE_HD inline float square_root(float x) { return ::sqrtf(x); }
HASTE_HD inline double square_root(double x) { return ::sqrt(x); }

/// The lesser and the greater; `b`, which must be a number, where `a` is none. One instruction on
/// either side, for a comparison and a choice would be two on the GPU.
#if defined(__CUDA_ARCH__)
HASTE_HD inline float number_minimum(float a, float b) { return ::fminf(a, b); }
HASTE_HD inline float number_maximum(float a, float b) { return ::fmaxf(a, b); }
HASTE_HD inline double number_minimum(double a, double b) { return ::fmin(a, b); }
HASTE_HD inline double number_maximum(double a, double b) { return ::fmax(a, b); }
#else
HASTE_HD inline float number_minimum(float a, float b) { return a < b ? a : b; }
HASTE_HD inline float number_maximum(float a, float b) { return a > b ? a : b; }
HASTE_HD inline double number_minimum(double a, double b) { return a < b ? a : b; }
HASTE_HD inline double number_maximum(double a, double b) { return a > b ? a : b; }
#endif

/// Operations on bits that one instruction of the platform does: how many are set, and which set
/// bit is the highest or the lowest (of a word that is not zero).
#if defined(__CUDA_ARCH__)
HASTE_HD inline u32 count_bits(u32 x) { return u32(::__popc(int(x))); }
HASTE_HD inline u32 highest_bit(u32 x) { return 31u - u32(::__clz(int(x))); }
HASTE_HD inline u32 lowest_bit(u32 x) { return u32(::__ffs(int(x))) - 1u; }
#else
HASTE_HD inline u32 count_bits(u32 x) { return u32(__builtin_popcount(x)); }
HASTE_HD inline u32 highest_bit(u32 x) { return 31u - u32(__builtin_clz(x)); }
HASTE_HD inline u32 lowest_bit(u32 x) { return u32(__builtin_ctz(x)); }
#endif

/// What GPUs have an instruction for: four bytes out of the eight of (b, a), each chosen by four
/// bits of the selector, of which three count; and the extremes of three integers.
#if defined(__CUDA_ARCH__)
inline constexpr bool on_device = true;
struct EightFloats;
HASTE_HD inline u32 choose_bytes(u32 a, u32 b, u32 selector) {
    return ::__byte_perm(a, b, selector);
}
HASTE_HD inline i32 least_of_three(i32 a, i32 b, i32 c) { return ::__vimin3_s32(a, b, c); }
HASTE_HD inline i32 greatest_of_three(i32 a, i32 b, i32 c) { return ::__vimax3_s32(a, b, c); }
/// Clamped to [0, 1]: part of the multiplication that it follows.
HASTE_HD inline float saturate(float x) { return ::__saturatef(x); }
#else
inline constexpr bool on_device = false;
/// Eight numbers side by side, as the processor's compilers have them; a thread of a GPU is one
/// lane already.
using EightFloats = float __attribute__((vector_size(32)));
inline void eight_bytes(const u32 (&words)[2], EightFloats& numbers) {
    using EightWords = u32 __attribute__((vector_size(32)));
    using EightInts = i32 __attribute__((vector_size(32)));
    const EightWords both{words[0], words[0], words[0], words[0],
                          words[1], words[1], words[1], words[1]};
    const EightWords bytes = (both >> EightWords{0, 8, 16, 24, 0, 8, 16, 24}) & 0xffu;
    numbers = __builtin_convertvector(EightInts(bytes), EightFloats);
}
HASTE_HD inline u32 choose_bytes(u32 a, u32 b, u32 selector) {
    const u64 bytes = u64(b) << 32 | a;
    u32 chosen = 0;
    for (u32 i = 0; i < 4; ++i) {
        const u32 which = (selector >> (4 * i)) & 7u;
        chosen |= u32((bytes >> (8 * which)) & 0xffu) << (8 * i);
    }
    return chosen;
}
HASTE_HD inline i32 least_of_three(i32 a, i32 b, i32 c) {
    const i32 least = a < b ? a : b;
    return least < c ? least : c;
}
HASTE_HD inline i32 greatest_of_three(i32 a, i32 b, i32 c) {
    const i32 greatest = a > b ? a : b;
    return greatest > c ? greatest : c;
}
HASTE_HD inline float saturate(float x) { return x > 0.0f ? (x < 1.0f ? x : 1.0f) : 0.0f; }
#endif

/// The bits of a number and back.
HASTE_HD constexpr u32 float_bits(float x) { return __builtin_bit_cast(u32, x); }
HASTE_HD constexpr float bits_float(u32 x) { return __builtin_bit_cast(float, x); }
HASTE_HD constexpr u64 double_bits(double x) { return __builtin_bit_cast(u64, x); }
HASTE_HD constexpr double bits_double(u64 x) { return __builtin_bit_cast(double, x); }

}  // namespace haste
