// Rows of tracks into lanes and back: square blocks turned in registers, a run of memory per lane.
#pragma once

#include "number/number.hpp"

namespace jink::inline JINK_LEVEL {

// r[i][l] <-> r[l][i]
JINK_INLINE void transpose(Pack (&r)[lanes]) {
#if JINK_LANES == 8
#define JINK_TURN(a, b, ...)                                              \
    {                                                                     \
        const Pack low = __builtin_shufflevector(r[a], r[b], __VA_ARGS__); \
        r[b] = __builtin_shufflevector(r[a], r[b], JINK_HIGH);             \
        r[a] = low;                                                       \
    }
#define JINK_HIGH 1, 9, 3, 11, 5, 13, 7, 15
    JINK_TURN(0, 1, 0, 8, 2, 10, 4, 12, 6, 14)
    JINK_TURN(2, 3, 0, 8, 2, 10, 4, 12, 6, 14)
    JINK_TURN(4, 5, 0, 8, 2, 10, 4, 12, 6, 14)
    JINK_TURN(6, 7, 0, 8, 2, 10, 4, 12, 6, 14)
#undef JINK_HIGH
#define JINK_HIGH 2, 3, 10, 11, 6, 7, 14, 15
    JINK_TURN(0, 2, 0, 1, 8, 9, 4, 5, 12, 13)
    JINK_TURN(1, 3, 0, 1, 8, 9, 4, 5, 12, 13)
    JINK_TURN(4, 6, 0, 1, 8, 9, 4, 5, 12, 13)
    JINK_TURN(5, 7, 0, 1, 8, 9, 4, 5, 12, 13)
#undef JINK_HIGH
#define JINK_HIGH 4, 5, 6, 7, 12, 13, 14, 15
    JINK_TURN(0, 4, 0, 1, 2, 3, 8, 9, 10, 11)
    JINK_TURN(1, 5, 0, 1, 2, 3, 8, 9, 10, 11)
    JINK_TURN(2, 6, 0, 1, 2, 3, 8, 9, 10, 11)
    JINK_TURN(3, 7, 0, 1, 2, 3, 8, 9, 10, 11)
#undef JINK_HIGH
#undef JINK_TURN
#else
    Pack turned[lanes] = {};
    JINK_UNROLL
    for (int i = 0; i < lanes; ++i)
        JINK_UNROLL
        for (int l = 0; l < lanes; ++l) turned[i][l] = r[l][i];
    JINK_UNROLL
    for (int i = 0; i < lanes; ++i) r[i] = turned[i];
#endif
}

// `values` numbers of each lane, from a pointer per lane, into `values` packs.
inline void to_lanes(const double *const *from, std::int64_t values, double *packs) {
    std::int64_t k = 0;
    for (; k + lanes <= values; k += lanes) {
        Pack r[lanes];
        JINK_UNROLL
        for (int l = 0; l < lanes; ++l) r[l] = load<Pack>(from[l] + k);
        transpose(r);
        JINK_UNROLL
        for (int l = 0; l < lanes; ++l) store(packs + (k + l) * lanes, r[l]);
    }
    for (; k < values; ++k)
        for (int l = 0; l < lanes; ++l) packs[k * lanes + l] = from[l][k];
}

inline void from_lanes(const double *packs, std::int64_t values, double *const *to, bool large) {
    std::int64_t k = 0;
    for (int l = 0; l < lanes; ++l) large = large && reinterpret_cast<std::uintptr_t>(to[l]) % sizeof(Pack) == 0;
    for (; large && k + lanes <= values; k += lanes) {
        Pack r[lanes];
        JINK_UNROLL
        for (int l = 0; l < lanes; ++l) r[l] = load<Pack>(packs + (k + l) * lanes);
        transpose(r);
        JINK_UNROLL
        for (int l = 0; l < lanes; ++l) store_past(to[l] + k, r[l]);
    }
    for (; k + lanes <= values; k += lanes) {
        Pack r[lanes];
        JINK_UNROLL
        for (int l = 0; l < lanes; ++l) r[l] = load<Pack>(packs + (k + l) * lanes);
        transpose(r);
        JINK_UNROLL
        for (int l = 0; l < lanes; ++l) store(to[l] + k, r[l]);
    }
    for (; k < values; ++k)
        for (int l = 0; l < lanes; ++l) to[l][k] = packs[k * lanes + l];
}

}  // namespace jink::inline JINK_LEVEL
