// A mode's message through the motion from the scan before (Passage): B, what enters, c and h.
#pragma once

#include "run/smooth_roots.hpp"

namespace jink::inline JINK_LEVEL {

template <class T, int N> [[gnu::noinline]] void smooth_pull(const T *R, const T *F, T *B) {
    for (int r = 0; r < N; ++r)
        JINK_UNROLL
        for (int j = 0; j < N; ++j) {
            T sum = R[packed(r, r)] * F[r * N + j];
            for (int i = r + 1; i < N; ++i) sum = sum + R[packed(i, r)] * F[i * N + j];
            B[r * N + j] = sum;
        }
}

// Nothing asks for the columns of what has entered: no start differs from another there.
template <class T, int N, int B> [[gnu::noinline]] T smooth_enter(const T *v, int entered, T *M, T &scale) {
    using O = Order<N, B>;
    T square = v[0] * v[0];
    JINK_UNROLL
    for (int r = 1; r < N; ++r) square = square + v[r] * v[r];
    const T grown = 1.0 + square, over = reciprocal_root(grown);
    scale = reciprocal(grown + grown * over);
    for (int k = 0; k < N; ++k) {
        if (k >= O::shared && k < O::shared + entered) continue;
        T *column = M + O::at(k), along = v[0] * column[0];
        JINK_UNROLL
        for (int r = 1; r < N; ++r) along = along + v[r] * column[r * N];
        along = along * scale;
        JINK_UNROLL
        for (int r = 0; r < N; ++r) column[r * N] = column[r * N] - v[r] * along;
    }
    return over;
}

// B' B, of the first K components in order.
template <class T, int N, int B, int K> [[gnu::noinline]] void smooth_gram(const T *M, T *J) {
    using O = Order<N, B>;
    JINK_UNROLL
    for (int i = 0; i < K; ++i)
        JINK_UNROLL
        for (int j = 0; j <= i; ++j) {
            T sum = M[O::at(i)] * M[O::at(j)];
            JINK_UNROLL
            for (int r = 1; r < N; ++r) sum = sum + M[r * N + O::at(i)] * M[r * N + O::at(j)];
            J[packed(i, j)] = sum;
        }
}

// c of the state that the passage was opened from; `entering` times B's turn is done to it as well.
template <class T, int N> [[gnu::noinline]] void smooth_listen(const T *ahead, const T *x, int entering, Passage<T> &by) {
    T d[N], c[N];
    JINK_UNROLL
    for (int k = 0; k < N; ++k) d[k] = ahead[k] - x[k];
    JINK_UNROLL
    for (int i = 0; i < N; ++i) {
        c[i] = by.root->g[i];
        JINK_UNROLL
        for (int k = i; k < N; ++k) c[i] = c[i] - by.root->R[packed(k, i)] * d[k];
    }
    for (int e = 0; e < entering; ++e) {
        const T *v = &by.v[e * largest_state];
        T along = v[0] * c[0];
        JINK_UNROLL
        for (int r = 1; r < N; ++r) along = along + v[r] * c[r];
        along = along * by.scale[e];
        JINK_UNROLL
        for (int r = 0; r < N; ++r) c[r] = c[r] - v[r] * along;
    }
    JINK_UNROLL
    for (int k = 0; k < N; ++k) by.c[k] = c[k];
}

template <class T, int N, int B, int K> [[gnu::noinline]] T smooth_hear(const Passage<T> &by, const T *start, T *h) {
    using O = Order<N, B>;
    T d[K], c[N], sum[K];
    JINK_UNROLL
    for (int r = 0; r < N; ++r) c[r] = by.c[r];
    if (start) {
        JINK_UNROLL
        for (int k = 0; k < K; ++k) d[k] = start[O::at(k)] - by.start[O::at(k)];
        JINK_UNROLL
        for (int r = 0; r < N; ++r)
            JINK_UNROLL
            for (int k = 0; k < K; ++k) c[r] = c[r] - by.B[r * N + O::at(k)] * d[k];
    }
    T square = c[0] * c[0];
    JINK_UNROLL
    for (int k = 0; k < K; ++k) sum[k] = by.B[O::at(k)] * c[0];
    JINK_UNROLL
    for (int r = 1; r < N; ++r) {
        square = square + c[r] * c[r];
        JINK_UNROLL
        for (int k = 0; k < K; ++k) sum[k] = sum[k] + by.B[r * N + O::at(k)] * c[r];
    }
    JINK_UNROLL
    for (int k = 0; k < K; ++k) h[k] = sum[k];
    return by.s - 0.5 * square;
}

}  // namespace jink::inline JINK_LEVEL
