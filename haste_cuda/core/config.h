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

/// Elementary functions of the platform: within 2 ulp, not equal bit for bit across platforms.
HASTE_HD inline float exponential(float x) { return ::expf(x); }
HASTE_HD inline double exponential(double x) { return ::exp(x); }
HASTE_HD inline float exponential_minus_one(float x) { return ::expm1f(x); }
HASTE_HD inline double exponential_minus_one(double x) { return ::expm1(x); }
HASTE_HD inline float logarithm(float x) { return ::logf(x); }
HASTE_HD inline double logarithm(double x) { return ::log(x); }
HASTE_HD inline float logarithm_of_one_plus(float x) { return ::log1pf(x); }
HASTE_HD inline double logarithm_of_one_plus(double x) { return ::log1p(x); }
HASTE_HD inline float cube_root(float x) { return ::cbrtf(x); }
HASTE_HD inline double cube_root(double x) { return ::cbrt(x); }

/// The bits of a float, for the film's exact conversion.
HASTE_HD constexpr u32 float_bits(float x) { return __builtin_bit_cast(u32, x); }

}  // namespace haste
