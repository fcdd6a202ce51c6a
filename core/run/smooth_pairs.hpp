// A mode's filtered estimate and the messages that it hears: their products, what the pairs of a mode become together, and its message.
#pragma once

#include "run/smooth_roots.hpp"

namespace jink::inline JINK_LEVEL {

// I + L' J L over the first K components.
template <class T, int K> JINK_INLINE void whiten(const T *L, const T *J, T *S) {
    JINK_UNROLL
    for (int k = 0; k < K; ++k) {
        T JL[K];
        JINK_UNROLL
        for (int i = k; i < K; ++i) {
            T sum = J[packed(i, k)] * L[packed(k, k)];
            JINK_UNROLL
            for (int l = k + 1; l < K; ++l) sum = sum + J[packed(i, l)] * L[packed(l, k)];
            JL[i] = sum;
        }
        JINK_UNROLL
        for (int i = k; i < K; ++i) {
            T sum = L[packed(i, i)] * JL[i];
            JINK_UNROLL
            for (int l = i + 1; l < K; ++l) sum = sum + L[packed(l, i)] * JL[l];
            S[packed(i, k)] = i == k ? sum + 1.0 : sum;
        }
    }
}

// The message's mean under N(x, L L') from over_det = 1 / det U and u = U^-1 L' h, I + L' J L = U U'.
template <class T, int K> JINK_INLINE Scaled<T> level_of(T over_det, const T *u) {
    Scaled<T> mean = scaled<T>(over_det);
    T gain = u[0] * u[0];
    JINK_UNROLL
    for (int i = 1; i < K; ++i) gain = gain + u[i] * u[i];
    mean.log = mean.log + 0.5 * gain;
    return mean;
}

// u = U^-1 L' h.
template <class T, int K> JINK_INLINE void solve_gain(const T *U, const T *over, const T *L, const T *h, T *u) {
    JINK_UNROLL
    for (int i = 0; i < K; ++i) {
        u[i] = L[packed(i, i)] * h[i];
        JINK_UNROLL
        for (int l = i + 1; l < K; ++l) u[i] = u[i] + L[packed(l, i)] * h[l];
    }
    solve_upper_root<T, K>(U, over, u);
}

// to = x + V u, of the first K columns of V.
template <class T, int N, int B, int K> JINK_INLINE void move_along(const T *V, const T *u, const T *x, T *to) {
    using O = Order<N, B>;
    JINK_UNROLL
    for (int i = 0; i < N; ++i) {
        T sum = x[O::at(i)];
        JINK_UNROLL
        for (int k = 0; k <= std::min(i, K - 1); ++k) sum = sum + V[packed(i, k)] * u[k];
        to[O::at(i)] = sum;
    }
}

// With V = L U'^-1 the covariance is V V', u = V' h and the mean x + V u.
template <class T, int N, int B, int K>
[[gnu::noinline]] Scaled<T> smooth_fuse(const T *L, const T *J, const T *h, const T *x, T *to, T *P) {
    using O = Order<N, B>;
    T S[packed_size(K)], U[packed_size(K)], over[K], u[K];
    whiten<T, K>(L, J, S);
    const T over_det = upper_root<T, K>(S, U, over);
    if (!P) {
        solve_gain<T, K>(U, over, L, h, u);
        const Scaled<T> mean = level_of<T, K>(over_det, u);
        JINK_UNROLL
        for (int i = 0; i < K; ++i) {  // U'^-1 u
            JINK_UNROLL
            for (int l = 0; l < i; ++l) u[i] = u[i] - U[packed(i, l)] * u[l];
            u[i] = u[i] * over[i];
        }
        move_along<T, N, B, K>(L, u, x, to);
        return mean;
    }
    T V[packed_size(N)];
    solve_root<T, N, K>(U, over, L, V);
    JINK_UNROLL
    for (int k = 0; k < K; ++k) {
        u[k] = V[packed(k, k)] * h[k];
        JINK_UNROLL
        for (int r = k + 1; r < K; ++r) u[k] = u[k] + V[packed(r, k)] * h[r];
    }
    move_along<T, N, B, K>(V, u, x, to);
    JINK_UNROLL
    for (int i = 0; i < N; ++i)
        JINK_UNROLL
        for (int j = 0; j <= i; ++j) {
            T sum = V[packed(i, 0)] * V[packed(j, 0)];
            JINK_UNROLL
            for (int k = 1; k <= j; ++k) sum = sum + V[packed(i, k)] * V[packed(j, k)];
            P[O::square(i, j)] = sum;
        }
    return level_of<T, K>(over_det, u);
}

template <class T, int N, int B> [[gnu::noinline]] Scaled<T> smooth_level(const T *L, const T *J, const T *h) {
    using O = Order<N, B>;
    T ordered[packed_size(N)], told[N], S[packed_size(N)], U[packed_size(N)], over[N], u[N];
    JINK_UNROLL
    for (int i = 0; i < N; ++i) {
        told[i] = h[O::at(i)];
        JINK_UNROLL
        for (int j = 0; j <= i; ++j) ordered[packed(i, j)] = J[O::square(i, j)];
    }
    whiten<T, N>(L, ordered, S);
    const T over_det = upper_root<T, N>(S, U, over);
    solve_gain<T, N>(U, over, L, told, u);
    return level_of<T, N>(over_det, u);
}

// Pair after pair: w_k of them together and their mean x_k, the spread grows by w_(k-1) share_k / w_k d d', d = x of pair k - x_(k-1).
template <class T, int N, int B>
[[gnu::noinline]] void smooth_merge(const SmoothPair<T> *pairs, int count, T *x, T *P, T *J, T *h, T *V) {
    using O = Order<N, B>;
    constexpr int size = packed_size(N), shared = O::shared;
    T mean[N], told[N], M[size], weight = pairs[0].share;
    JINK_UNROLL
    for (int k = 0; k < N; ++k) mean[k] = pairs[0].x[k], told[k] = splat<T>(0.0);
    JINK_UNROLL
    for (int k = 0; k < size; ++k) M[k] = splat<T>(0.0);
    for (int j = 0; j < count; ++j) {
        const SmoothPair<T> &p = pairs[j];
        JINK_UNROLL
        for (int r = 0; r < shared; ++r) {
            told[r] = told[r] + p.share * p.h[r];
            JINK_UNROLL
            for (int q = 0; q <= r; ++q) M[packed(r, q)] = M[packed(r, q)] + p.share * p.J[packed(r, q)];
        }
        if (N == shared || !p.whole) continue;
        JINK_UNROLL
        for (int r = shared; r < N; ++r) {
            told[r] = told[r] + p.share * p.h[r];
            JINK_UNROLL
            for (int q = 0; q <= r; ++q) M[packed(r, q)] = M[packed(r, q)] + p.share * p.J[packed(r, q)];
        }
    }
    JINK_UNROLL
    for (int r = 0; r < N; ++r) {
        h[O::at(r)] = told[r];
        JINK_UNROLL
        for (int q = 0; q <= r; ++q) J[O::square(r, q)] = M[packed(r, q)];
    }
    for (int j = 1; j < count; ++j) {
        const SmoothPair<T> &p = pairs[j];
        const T together = weight + p.share, part = p.share * reciprocal(larger<T>(together, splat<T>(1e-300)));
        const T product = weight * part, root = product * reciprocal_root(larger<T>(product, splat<T>(1e-300)));
        weight = together;
        JINK_UNROLL
        for (int k = 0; k < N; ++k) {
            const T d = p.x[k] - mean[k];
            V[(j - 1) * N + k] = root * d;
            mean[k] = mean[k] + part * d;
        }
    }
    JINK_UNROLL
    for (int k = 0; k < N; ++k) x[k] = mean[k];
    if (!P) return;
    T C[size];
    JINK_UNROLL
    for (int k = 0; k < size; ++k) C[k] = pairs[0].share * pairs[0].P[k];
    for (int j = 1; j < count; ++j) {
        const T share = pairs[j].share, *v = V + (j - 1) * N;
        JINK_UNROLL
        for (int r = 0; r < N; ++r)
            JINK_UNROLL
            for (int q = 0; q <= r; ++q) C[packed(r, q)] = C[packed(r, q)] + share * pairs[j].P[packed(r, q)] + v[r] * v[q];
    }
    JINK_UNROLL
    for (int k = 0; k < N; ++k) C[packed(k, k)] = C[packed(k, k)] * (1.0 + rounding_share(N));
    JINK_UNROLL
    for (int k = 0; k < size; ++k) P[k] = C[k];
}

template <class T, int N> [[gnu::noinline]] T smooth_thin(const T *V, int columns, T *J, T *h) {
    T A[packed_size(N)], b[N], grown = splat<T>(1.0);
    JINK_UNROLL
    for (int k = 0; k < packed_size(N); ++k) A[k] = J[k];
    JINK_UNROLL
    for (int k = 0; k < N; ++k) b[k] = h[k];
    for (int c = 0; c < columns; ++c) {
        const T *v = V + c * N;
        T w[N], square = splat<T>(0.0), along = splat<T>(0.0);
        JINK_UNROLL
        for (int i = 0; i < N; ++i) {
            w[i] = A[packed(i, 0)] * v[0];
            JINK_UNROLL
            for (int k = 1; k < N; ++k) w[i] = w[i] + A[packed(i, k)] * v[k];
            square = square + v[i] * w[i], along = along + v[i] * b[i];
        }
        const T factor = 1.0 + square, over = reciprocal(factor);
        grown = grown * factor;
        along = along * over;
        JINK_UNROLL
        for (int i = 0; i < N; ++i) {
            const T part = w[i] * over;
            b[i] = b[i] - w[i] * along;
            JINK_UNROLL
            for (int k = 0; k <= i; ++k) A[packed(i, k)] = A[packed(i, k)] - part * w[k];
        }
    }
    JINK_UNROLL
    for (int k = 0; k < packed_size(N); ++k) J[k] = A[k];
    JINK_UNROLL
    for (int k = 0; k < N; ++k) h[k] = b[k];
    return grown;
}

template <class T, int N> [[gnu::noinline]] void smooth_spread(const T *V, int columns, MessageRoot<T> &m, T *J, T *h) {
    T S[packed_size(N)], U[packed_size(N)], over[N], W[packed_size(N)];
    JINK_UNROLL
    for (int i = 0; i < N; ++i)
        JINK_UNROLL
        for (int k = 0; k <= i; ++k) S[packed(i, k)] = splat<T>(i == k ? 1.0 : 0.0);
    for (int c = 0; c < columns; ++c) {
        T v[N];
        JINK_UNROLL
        for (int i = 0; i < N; ++i) {
            v[i] = m.R[packed(i, i)] * V[c * N + i];
            JINK_UNROLL
            for (int l = i + 1; l < N; ++l) v[i] = v[i] + m.R[packed(l, i)] * V[c * N + l];
        }
        JINK_UNROLL
        for (int i = 0; i < N; ++i)
            JINK_UNROLL
            for (int k = 0; k <= i; ++k) S[packed(i, k)] = S[packed(i, k)] + v[i] * v[k];
    }
    upper_root<T, N>(S, U, over);
    solve_root<T, N>(U, over, m.R, W);
    solve_upper_root<T, N>(U, over, m.g);
    smooth_square<T, N>(W, J);
    JINK_UNROLL
    for (int i = 0; i < N; ++i) {  // h = R g
        T sum = W[packed(i, 0)] * m.g[0];
        JINK_UNROLL
        for (int k = 1; k <= i; ++k) sum = sum + W[packed(i, k)] * m.g[k];
        h[i] = sum;
    }
}

template <class T, int N> [[gnu::noinline]] T smooth_unsound(const T *x, const T *P, const Message<T> &m) {
    T sum[4] = {m.s * 0.0, m.rest * 0.0, splat<T>(0.0), splat<T>(0.0)};
    JINK_UNROLL
    for (int k = 0; k < N; ++k) sum[k % 4] = sum[k % 4] + (x[k] * to_farthest) * 0.0 + m.h[k] * 0.0;
    JINK_UNROLL
    for (int k = 0; k < packed_size(N); ++k) sum[k % 4] = sum[k % 4] + m.J[k] * 0.0;
    if (P) {
        JINK_UNROLL
        for (int k = 0; k < packed_size(N); ++k) sum[k % 4] = sum[k % 4] + P[k] * 0.0;
        JINK_UNROLL
        for (int k = 0; k < N; ++k) sum[k % 4] = sum[k % 4] + (P[packed(k, k)] * to_least_certain) * 0.0;
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

}  // namespace jink::inline JINK_LEVEL
