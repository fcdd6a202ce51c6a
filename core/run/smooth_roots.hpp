// Triangular roots, which the smoother of several modes computes with.
//
// A root is taken once per mode; noise and the fusion with an estimate then leave triangles triangular: I + R' Q R = U U' with an
// upper triangular U, and U^-1 R' is upper triangular as well. Sums of squares only: nothing large is subtracted.
#pragma once

#include "run/smooth_message.hpp"

namespace jink::inline JINK_LEVEL {

// The order of a state in which that comes first which modes of any kind have, [p v] of each axis.
template <int N, int B> struct Order {
    static constexpr int shared = B == 3 ? N / 3 * 2 : N / 2 * 2;
    static constexpr int at(int k) { return B != 3 ? k : k < shared ? k / 2 * 3 + k % 2 : (k - shared) * 3 + 2; }
    static constexpr int square(int i, int j) { return packed(at(i), at(j)); }
};

// S = U U' with an upper triangular U, kept as the lower triangle of U'. Pivots are at least one, because S - I is semidefinite.
// Returns 1 / det U; `over` gets the reciprocals of the diagonal.
template <class T, int N> JINK_INLINE T upper_root(const T *S, T *U, T *over) {
    T over_det = splat<T>(1.0);
    JINK_UNROLL
    for (int j = N - 1; j >= 0; --j) {
        T pivot = S[packed(j, j)];
        JINK_UNROLL
        for (int k = N - 1; k > j; --k) pivot = pivot - U[packed(k, j)] * U[packed(k, j)];
        pivot = select<T>(pivot < splat<T>(1.0), splat<T>(1.0), pivot);  // NaN stays
        over[j] = reciprocal_root(pivot);
        over_det = over_det * over[j];
        JINK_UNROLL
        for (int i = 0; i < j; ++i) {
            T sum = S[packed(j, i)];
            JINK_UNROLL
            for (int k = N - 1; k > j; --k) sum = sum - U[packed(k, i)] * U[packed(k, j)];
            U[packed(j, i)] = sum * over[j];
        }
    }
    return over_det;
}

// R (U^-1)' for a lower triangular R of N rows, whose columns from K on stay as they are: U has K rows.
template <class T, int N, int K = N> JINK_INLINE void solve_root(const T *U, const T *over, const T *R, T *W) {
    JINK_UNROLL
    for (int k = K; k < N; ++k)
        JINK_UNROLL
        for (int i = K; i <= k; ++i) W[packed(k, i)] = R[packed(k, i)];
    JINK_UNROLL
    for (int i = K - 1; i >= 0; --i)
        JINK_UNROLL
        for (int k = i; k < N; ++k) {
            T sum = R[packed(k, i)];
            JINK_UNROLL
            for (int l = i + 1; l <= std::min(k, K - 1); ++l) sum = sum - U[packed(l, i)] * W[packed(k, l)];
            W[packed(k, i)] = sum * over[i];
        }
}

// U^-1 g, in place.
template <class T, int N> JINK_INLINE void solve_upper_root(const T *U, const T *over, T *g) {
    JINK_UNROLL
    for (int i = N - 1; i >= 0; --i) {
        T sum = g[i];
        JINK_UNROLL
        for (int l = i + 1; l < N; ++l) sum = sum - U[packed(l, i)] * g[l];
        g[i] = sum * over[i];
    }
}

// J = R R'.
template <class T, int N> JINK_INLINE void smooth_square(const T *R, T *J) {
    JINK_UNROLL
    for (int i = 0; i < N; ++i)
        JINK_UNROLL
        for (int j = 0; j <= i; ++j) {
            T sum = R[packed(i, 0)] * R[packed(j, 0)];
            JINK_UNROLL
            for (int k = 1; k <= j; ++k) sum = sum + R[packed(i, k)] * R[packed(j, k)];
            J[packed(i, j)] = sum;
        }
}

// P = L L' of the reordered P.
template <class T, int N, int B> [[gnu::noinline]] void smooth_factor(const T *P, T *L) {
    using O = Order<N, B>;
    JINK_UNROLL
    for (int j = 0; j < N; ++j) {
        const T variance = P[O::square(j, j)];
        T pivot = variance;
        JINK_UNROLL
        for (int k = 0; k < j; ++k) pivot = pivot - L[packed(j, k)] * L[packed(j, k)];
        const T least = larger<T>(2.220446049250313e-16 * variance, splat<T>(1e-300));
        pivot = select<T>(pivot < least, least, pivot);  // NaN stays
        const T scale = reciprocal_root(pivot);
        L[packed(j, j)] = pivot * scale;
        JINK_UNROLL
        for (int i = j + 1; i < N; ++i) {
            T sum = P[O::square(i, j)];
            JINK_UNROLL
            for (int k = 0; k < j; ++k) sum = sum - L[packed(i, k)] * L[packed(j, k)];
            L[packed(i, j)] = sum * scale;
        }
    }
}

// A pivot lost in rounding (or in what was subtracted before, see thin) leaves its column, and its g, zero; h has nothing there.
template <class T, int N> [[gnu::noinline]] void smooth_root(const Message<T> &m, MessageRoot<T> &to) {
    const T zero = splat<T>(0.0);
    const T least = rounding_share(N) * m.grown;
    T rest[N], R[packed_size(N)], s = m.s;
    JINK_UNROLL
    for (int i = 0; i < N; ++i) rest[i] = m.h[i];
    JINK_UNROLL
    for (int j = 0; j < N; ++j) {
        T pivot = m.J[packed(j, j)];
        JINK_UNROLL
        for (int k = 0; k < j; ++k) pivot = pivot - R[packed(j, k)] * R[packed(j, k)];
        const Mask<T> real = pivot > least * m.J[packed(j, j)];
        const T scale = select<T>(real, reciprocal_root(select<T>(real, pivot, splat<T>(1.0))), zero);
        const T g = rest[j] * scale;
        R[packed(j, j)] = to.R[packed(j, j)] = select<T>(real, pivot * scale, zero);
        to.g[j] = g, s = s + 0.5 * g * g;
        JINK_UNROLL
        for (int i = j + 1; i < N; ++i) {
            T sum = m.J[packed(i, j)];
            JINK_UNROLL
            for (int k = 0; k < j; ++k) sum = sum - R[packed(i, k)] * R[packed(j, k)];
            R[packed(i, j)] = to.R[packed(i, j)] = sum * scale;
            rest[i] = rest[i] - R[packed(i, j)] * g;
        }
    }
    to.s = s, to.rest = m.rest;
}

// Process noise couples the components of a block of B, one axis of the state; a turn rate is by itself.
template <class T, int N, int B> [[gnu::noinline]] void smooth_blur(const T *Q, MessageRoot<T> &m) {
    T S[packed_size(N)], U[packed_size(N)], over[N], W[packed_size(N)];
    JINK_UNROLL
    for (int k = 0; k < N; ++k) {
        T QR[N];
        JINK_UNROLL
        for (int i = k / B * B; i < N; ++i) {
            const int first = std::max(k, i / B * B), end = std::min(N, (i / B + 1) * B);
            QR[i] = Q[packed(i, first)] * m.R[packed(first, k)];
            JINK_UNROLL
            for (int l = first + 1; l < end; ++l) QR[i] = QR[i] + Q[packed(i, l)] * m.R[packed(l, k)];
        }
        JINK_UNROLL
        for (int i = k; i < N; ++i) {
            T sum = m.R[packed(i, i)] * QR[i];
            JINK_UNROLL
            for (int l = i + 1; l < N; ++l) sum = sum + m.R[packed(l, i)] * QR[l];
            S[packed(i, k)] = i == k ? sum + 1.0 : sum;
        }
    }
    const T over_det = upper_root<T, N>(S, U, over);
    solve_root<T, N>(U, over, m.R, W);
    solve_upper_root<T, N>(U, over, m.g);
    std::copy_n(W, packed_size(N), m.R);
    const Scaled<T> over_root = scaled<T>(over_det);
    m.s = m.s + over_root.log, m.rest = m.rest * over_root.rest;
}

}  // namespace jink::inline JINK_LEVEL
