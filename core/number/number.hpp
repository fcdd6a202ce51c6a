// The number types the filters run on, and the few operations they need.
//
// Every kernel is a template over a number T: `double` (one track) or `Pack` (one track per vector lane).
// Comparisons give a mask; `select(mask, a, b)` chooses lane by lane. NaN means "missing" and must propagate,
// so nothing here may be compiled with -ffast-math.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#ifndef JINK_LANES
#define JINK_LANES 2
#endif
#ifndef JINK_LEVEL
#define JINK_LEVEL baseline
#endif

#if defined(__AVX__)
#include <immintrin.h>
#endif

#define JINK_INLINE inline __attribute__((always_inline))
#define JINK_UNROLL_PACKS _Pragma("GCC unroll 16")
#ifndef JINK_UNROLL  // numbers with derivatives are too large to unroll: see motion_dual.cpp
#define JINK_UNROLL JINK_UNROLL_PACKS
#endif

namespace jink::inline JINK_LEVEL {

inline constexpr int lanes = JINK_LANES;
typedef double Pack __attribute__((vector_size(8 * JINK_LANES)));
typedef std::int64_t PackMask __attribute__((vector_size(8 * JINK_LANES)));

template <class T> struct NumberTraits;
template <> struct NumberTraits<double> {
    using Mask = bool;
    using Bits = std::int64_t;
    static constexpr int width = 1;
};
template <> struct NumberTraits<Pack> {
    using Mask = PackMask;
    using Bits = PackMask;
    static constexpr int width = lanes;
};
// Numbers in single precision, as many as there are tracks: of learned layers alone, which need no more.
typedef float PackSingle __attribute__((vector_size(4 * JINK_LANES)));
typedef std::int32_t PackSingleMask __attribute__((vector_size(4 * JINK_LANES)));
template <> struct NumberTraits<float> {
    using Mask = bool;
    using Bits = std::int32_t;
    static constexpr int width = 1;
};
template <> struct NumberTraits<PackSingle> {
    using Mask = PackSingleMask;
    using Bits = PackSingleMask;
    static constexpr int width = lanes;
};
template <class T> using Mask = typename NumberTraits<T>::Mask;
template <class T> using Bits = typename NumberTraits<T>::Bits;
template <class T> inline constexpr int width = NumberTraits<T>::width;
template <class T> using Single = std::conditional_t<width<T> == 1, float, PackSingle>;

template <class T> JINK_INLINE T splat(double value) {
    if constexpr (width<T> == 1) return T(value);
    else return value - T{};
}

template <> JINK_INLINE PackSingle splat<PackSingle>(double value) { return float(value) - PackSingle{}; }

JINK_INLINE float narrowed(double x) { return float(x); }
JINK_INLINE double widened(float x) { return x; }
#if defined(__AVX512F__) && JINK_LANES == 8  // GCC 12 converts lane by lane
JINK_INLINE PackSingle narrowed(Pack x) { return (PackSingle)_mm512_cvtpd_ps((__m512d)x); }
JINK_INLINE Pack widened(PackSingle x) { return (Pack)_mm512_cvtps_pd((__m256)x); }
#elif defined(__AVX__) && JINK_LANES == 4
JINK_INLINE PackSingle narrowed(Pack x) { return (PackSingle)_mm256_cvtpd_ps((__m256d)x); }
JINK_INLINE Pack widened(PackSingle x) { return (Pack)_mm256_cvtps_pd((__m128)x); }
#else
JINK_INLINE PackSingle narrowed(Pack x) { return __builtin_convertvector(x, PackSingle); }
JINK_INLINE Pack widened(PackSingle x) { return __builtin_convertvector(x, Pack); }
#endif

template <class T> JINK_INLINE Mask<T> splat_mask(bool value) {
    if constexpr (width<T> == 1) return value;
    else return Mask<T>{} - (value ? 1 : 0);
}

template <class T> JINK_INLINE T select(Mask<T> mask, T yes, T no) { return mask ? yes : no; }

JINK_INLINE bool inverse(bool mask) { return !mask; }
JINK_INLINE PackMask inverse(PackMask mask) { return ~mask; }
JINK_INLINE bool any(bool mask) { return mask; }
JINK_INLINE bool all(bool mask) { return mask; }

JINK_INLINE bool any(PackMask mask) {
#if defined(__AVX512F__) && JINK_LANES == 8
    return _mm512_test_epi64_mask((__m512i)mask, (__m512i)mask) != 0;
#elif defined(__AVX__) && JINK_LANES == 4
    return !_mm256_testz_si256((__m256i)mask, (__m256i)mask);
#else
    std::int64_t seen = 0;
    JINK_UNROLL
    for (int l = 0; l < lanes; ++l) seen |= mask[l];
    return seen != 0;
#endif
}
JINK_INLINE bool all(PackMask mask) { return !any(~mask); }

JINK_INLINE double lane(double value, int) { return value; }
JINK_INLINE double lane(Pack value, int l) { return value[l]; }
JINK_INLINE bool lane(bool mask, int) { return mask; }
JINK_INLINE bool lane(PackMask mask, int l) { return mask[l] != 0; }
JINK_INLINE void set_lane(double &value, int, double to) { value = to; }
JINK_INLINE void set_lane(Pack &value, int l, double to) { value[l] = to; }
JINK_INLINE void set_lane(bool &mask, int, bool to) { mask = to; }
JINK_INLINE void set_lane(PackMask &mask, int l, bool to) { mask[l] = to ? -1 : 0; }

template <class T> JINK_INLINE T load(const double *from) {
    T value;
    std::memcpy(&value, from, sizeof(T));
    return value;
}
template <class T> JINK_INLINE void store(double *to, T value) { std::memcpy(to, &value, sizeof(T)); }

// A store past the caches, for results too large to stay there; `to` must be aligned to the pack.
JINK_INLINE void store_past(double *to, Pack value) {
#if defined(__AVX512F__) && JINK_LANES == 8
    _mm512_stream_pd(to, (__m512d)value);
#elif defined(__AVX__) && JINK_LANES == 4
    _mm256_stream_pd(to, (__m256d)value);
#else
    store(to, value);
#endif
}

template <class T> JINK_INLINE Mask<T> is_nan(T x) { return x != x; }
template <class T> JINK_INLINE T nan_of() { return splat<T>(std::numeric_limits<double>::quiet_NaN()); }
template <class T> JINK_INLINE T larger(T a, T b) { return select<T>(a > b, a, b); }
template <class T> JINK_INLINE T smaller(T a, T b) { return select<T>(a < b, a, b); }
// The same in one instruction, which gives b where one of them is NaN and where both are zero, as above.
#if defined(__AVX512F__) && JINK_LANES == 8
template <> JINK_INLINE Pack larger<Pack>(Pack a, Pack b) { return (Pack)_mm512_max_pd((__m512d)a, (__m512d)b); }
template <> JINK_INLINE Pack smaller<Pack>(Pack a, Pack b) { return (Pack)_mm512_min_pd((__m512d)a, (__m512d)b); }
template <> JINK_INLINE PackSingle larger<PackSingle>(PackSingle a, PackSingle b) { return (PackSingle)_mm256_max_ps((__m256)a, (__m256)b); }
template <> JINK_INLINE PackSingle smaller<PackSingle>(PackSingle a, PackSingle b) { return (PackSingle)_mm256_min_ps((__m256)a, (__m256)b); }
#elif defined(__AVX__) && JINK_LANES == 4
template <> JINK_INLINE Pack larger<Pack>(Pack a, Pack b) { return (Pack)_mm256_max_pd((__m256d)a, (__m256d)b); }
template <> JINK_INLINE Pack smaller<Pack>(Pack a, Pack b) { return (Pack)_mm256_min_pd((__m256d)a, (__m256d)b); }
template <> JINK_INLINE PackSingle larger<PackSingle>(PackSingle a, PackSingle b) { return (PackSingle)_mm_max_ps((__m128)a, (__m128)b); }
template <> JINK_INLINE PackSingle smaller<PackSingle>(PackSingle a, PackSingle b) { return (PackSingle)_mm_min_ps((__m128)a, (__m128)b); }
#endif

JINK_INLINE double square_root(double x) { return std::sqrt(x); }
JINK_INLINE Pack square_root(Pack x) {
    Pack root;
    JINK_UNROLL
    for (int l = 0; l < lanes; ++l) root[l] = __builtin_sqrt(x[l]);
    return root;
}

// 1 / x and 1 / sqrt(x) of positive finite numbers: with AVX-512 an estimate of 14 bits and the first terms of the series of what it
// is off by (an ulp or two), instead of the divider, which is a tenth as fast.
template <class T> JINK_INLINE T reciprocal(T x) {
#if defined(__AVX512F__) && JINK_LANES == 8
    if constexpr (width<T> == 8) {
        const T y = (T)_mm512_rcp14_pd((__m512d)x), off = 1.0 - x * y;
        const T once = y + y * off;
        return once + once * (off * off);
    }
#endif
    return 1.0 / x;
}

template <class T> JINK_INLINE T reciprocal_root(T x) {
#if defined(__AVX512F__) && JINK_LANES == 8
    if constexpr (width<T> == 8) {
        const T y = (T)_mm512_rsqrt14_pd((__m512d)x), off = 1.0 - (x * y) * y;
        return y + (y * off) * (0.5 + off * (0.375 + off * 0.3125));
    }
#endif
    return 1.0 / square_root(x);
}

template <class T> JINK_INLINE Bits<T> to_bits(T x) {
    Bits<T> bits;
    std::memcpy(&bits, &x, sizeof(T));
    return bits;
}
template <class T> JINK_INLINE T from_bits(Bits<T> bits) {
    T x;
    std::memcpy(&x, &bits, sizeof(T));
    return x;
}

template <class T> JINK_INLINE T magnitude(T x) {
    return from_bits<T>(to_bits(x) & std::int64_t(0x7fffffffffffffff));
}

}  // namespace jink::inline JINK_LEVEL
