// Interaction: the mixture of the modes' estimates that a mode starts its scan from, matched in its first two moments.
//
//   x0_j = sum_i w_ij x_i ,   P0_j = sum_i w_ij (P_i + (x_i - x0_j)(x_i - x0_j)')
//
// Summed pair by pair: nothing is subtracted, so P0_j cannot lose definiteness. Sources are read through a table of places
// in the track's arena, so that a component the source lacks comes from a prior (or from the target mode itself).
// Blom & Bar-Shalom, IEEE Trans. AC-33(8), 1988; mixed dimensions: Granstrom, Willett & Bar-Shalom, Fusion 2015.
#pragma once

#include "number/matrix.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> using MixKernel = void (*)(const T *arena, const int *places, const T *weights, int modes, T *out);

// A source as the target sees it: x then P, either element by element through the table or, where it has the target's own
// components, as it lies in memory.
template <class T, bool Alike> struct Source {
    const T *arena;
    const int *places;
    JINK_INLINE T operator[](int k) const { return Alike ? arena[places[0] + k] : arena[places[k]]; }
};

template <class T, int N, bool Alike> void mix(const T *arena, const int *places, const T *weights, int modes, T *out) {
    constexpr int size = packed_size(N), stride = N + size;
    T x[N], P[size];
    JINK_UNROLL
    for (int c = 0; c < N; ++c) x[c] = weights[0] * Source<T, Alike>{arena, places}[c];
    for (int i = 1; i < modes; ++i) {
        const Source<T, Alike> from{arena, places + i * stride};
        JINK_UNROLL
        for (int c = 0; c < N; ++c) x[c] = x[c] + weights[i] * from[c];
    }
    JINK_UNROLL
    for (int k = 0; k < size; ++k) P[k] = splat<T>(0.0);
    for (int i = 0; i < modes; ++i) {
        const Source<T, Alike> from{arena, places + i * stride};
        const T w = weights[i];
        T d[N];
        JINK_UNROLL
        for (int c = 0; c < N; ++c) d[c] = from[c] - x[c];
        JINK_UNROLL
        for (int r = 0; r < N; ++r) {
            const T wd = w * d[r];
            JINK_UNROLL
            for (int c = 0; c < N; ++c)
                if (c <= r) P[packed(r, c)] = P[packed(r, c)] + w * from[N + packed(r, c)] + wd * d[c];
        }
    }
    JINK_UNROLL
    for (int c = 0; c < N; ++c) out[c] = x[c];
    JINK_UNROLL
    for (int k = 0; k < size; ++k) out[N + k] = P[k];
}

template <class T, bool Alike> MixKernel<T> mix_kernel(int n) {
    switch (n) {
        case 2: return mix<T, 2, Alike>;
        case 3: return mix<T, 3, Alike>;
        case 4: return mix<T, 4, Alike>;
        case 5: return mix<T, 5, Alike>;
        case 6: return mix<T, 6, Alike>;
        case 7: return mix<T, 7, Alike>;
        default: return mix<T, 9, Alike>;
    }
}

}  // namespace jink::inline JINK_LEVEL
