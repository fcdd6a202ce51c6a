// Interaction: the mixture of the modes' estimates that a mode starts its scan from, matched in its first two moments.
//
//   x0_j = sum_i w_ij x_i ,   P0_j = sum_i w_ij (P_i + (x_i - x0_j)(x_i - x0_j)')
//
// Summed pair by pair: nothing is subtracted, so P0_j cannot lose definiteness. Sources are read through a table of places
// in the track's arena, so that a component the source lacks comes from a prior (or from the target mode itself).
// Blom & Bar-Shalom, IEEE Trans. AC-33(8), 1988; mixed dimensions: Granstrom, Willett & Bar-Shalom, Fusion 2015.
#pragma once

#include "number/dual.hpp"
#include "number/matrix.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> using MixKernel = void (*)(const T *arena, const int *places, const T *weights, int modes, T *out);

// A source as the target sees it: x then P, either element by element through the table or, where it has the target's own
// components, as it lies in memory.
template <class T, bool Alike> struct Source {
    const T *arena;
    const int *places;
    JINK_INLINE const T &operator[](int k) const { return Alike ? arena[places[0] + k] : arena[places[k]]; }
};

// The slopes, one after the other: with d the deviations from x0,
//   (w P)' = w' P + w P' ,   (w d d')' = u d' + d u'  with  u = w'/2 d + w (x' - x0')
template <WithSlopes T, int N, bool Alike> void mix_slopes(const T *arena, const int *places, const T *weights, int modes, T *out) {
    using V = Value<T>;
    constexpr int size = packed_size(N), stride = N + size;
    for (int k = 0; k < T::slopes; ++k) {
        V x[N], P[size];
        JINK_UNROLL_PACKS
        for (int c = 0; c < N; ++c) x[c] = splat<V>(0.0);
        for (int i = 0; i < modes; ++i) {
            const Source<T, Alike> from{arena, places + i * stride};
            JINK_UNROLL_PACKS
            for (int c = 0; c < N; ++c) x[c] = x[c] + weights[i].value * from[c].slope[k] + weights[i].slope[k] * from[c].value;
        }
        JINK_UNROLL_PACKS
        for (int e = 0; e < size; ++e) P[e] = splat<V>(0.0);
        for (int i = 0; i < modes; ++i) {
            const Source<T, Alike> from{arena, places + i * stride};
            const V w = weights[i].value, changed = weights[i].slope[k];
            V d[N], u[N];
            JINK_UNROLL_PACKS
            for (int c = 0; c < N; ++c) {
                d[c] = from[c].value - out[c].value;
                u[c] = 0.5 * changed * d[c] + w * (from[c].slope[k] - x[c]);
            }
            JINK_UNROLL_PACKS
            for (int r = 0; r < N; ++r)
                JINK_UNROLL_PACKS
                for (int c = 0; c < N; ++c) {
                    if (c > r) continue;
                    const T &source = from[N + packed(r, c)];
                    const V moved = P[packed(r, c)] + changed * source.value + w * source.slope[k];
                    P[packed(r, c)] = r == c ? moved + d[r] * (u[r] + u[r]) : moved + u[r] * d[c] + d[r] * u[c];
                }
        }
        JINK_UNROLL_PACKS
        for (int c = 0; c < N; ++c) out[c].slope[k] = x[c];
        JINK_UNROLL_PACKS
        for (int e = 0; e < size; ++e) out[N + e].slope[k] = P[e];
    }
}

template <class T, int N, bool Alike> void mix(const T *arena, const int *places, const T *weights, int modes, T *out) {
    using V = Value<T>;
    constexpr int size = packed_size(N), stride = N + size;
    V x[N], P[size];
    JINK_UNROLL_PACKS
    for (int c = 0; c < N; ++c) x[c] = value_of(weights[0]) * value_of(Source<T, Alike>{arena, places}[c]);
    for (int i = 1; i < modes; ++i) {
        const Source<T, Alike> from{arena, places + i * stride};
        JINK_UNROLL_PACKS
        for (int c = 0; c < N; ++c) x[c] = x[c] + value_of(weights[i]) * value_of(from[c]);
    }
    JINK_UNROLL_PACKS
    for (int k = 0; k < size; ++k) P[k] = splat<V>(0.0);
    for (int i = 0; i < modes; ++i) {
        const Source<T, Alike> from{arena, places + i * stride};
        const V w = value_of(weights[i]);
        V d[N];
        JINK_UNROLL_PACKS
        for (int c = 0; c < N; ++c) d[c] = value_of(from[c]) - x[c];
        JINK_UNROLL_PACKS
        for (int r = 0; r < N; ++r) {
            const V wd = w * d[r];
            JINK_UNROLL_PACKS
            for (int c = 0; c < N; ++c)
                if (c <= r) P[packed(r, c)] = P[packed(r, c)] + w * value_of(from[N + packed(r, c)]) + wd * d[c];
        }
    }
    JINK_UNROLL_PACKS
    for (int c = 0; c < N; ++c) value_of(out[c]) = x[c];
    JINK_UNROLL_PACKS
    for (int k = 0; k < size; ++k) value_of(out[N + k]) = P[k];
    if constexpr (WithSlopes<T>) mix_slopes<T, N, Alike>(arena, places, weights, modes, out);
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
