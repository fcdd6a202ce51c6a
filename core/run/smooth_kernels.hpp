// The arithmetic of the smoother of several modes, unrolled for each size of state.
//
// A root is taken once per mode; noise and the fusion with an estimate then leave triangles triangular: I + R' Q R = U U' with an
// upper triangular U, and U^-1 R' is upper triangular as well. Sums of squares only: nothing large is subtracted.
#pragma once

#include "run/smooth_message.hpp"

namespace jink::inline JINK_LEVEL {

// 1 / sqrt(x) of positive finite numbers. With AVX-512 the series of what the estimate of 14 bits is off by, which waits less than
// Newton's steps one after the other (an ulp or two as well).
template <class T> JINK_INLINE T over_root(T x) {
#if defined(__AVX512F__) && JINK_LANES == 8
    if constexpr (width<T> == 8) {
        const T y = (T)_mm512_rsqrt14_pd((__m512d)x), off = 1.0 - (x * y) * y;
        return y + (y * off) * (0.5 + off * (0.375 + off * 0.3125));
    }
#endif
    return reciprocal_root(x);
}

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
        over[j] = over_root(pivot);
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

// U^-1 R' for a lower triangular R, kept as the lower triangle of its transpose.
template <class T, int N> JINK_INLINE void solve_root(const T *U, const T *over, const T *R, T *W) {
    JINK_UNROLL
    for (int i = N - 1; i >= 0; --i)
        JINK_UNROLL
        for (int k = i; k < N; ++k) {
            T sum = R[packed(k, i)];
            JINK_UNROLL
            for (int l = i + 1; l <= k; ++l) sum = sum - U[packed(l, i)] * W[packed(k, l)];
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

// I + L' J L.
template <class T, int N> JINK_INLINE void whiten(const T *L, const T *J, T *S) {
    JINK_UNROLL
    for (int k = 0; k < N; ++k) {
        T JL[N];
        JINK_UNROLL
        for (int i = k; i < N; ++i) {
            T sum = J[packed(i, k)] * L[packed(k, k)];
            JINK_UNROLL
            for (int l = k + 1; l < N; ++l) sum = sum + J[packed(i, l)] * L[packed(l, k)];
            JL[i] = sum;
        }
        JINK_UNROLL
        for (int i = k; i < N; ++i) {
            T sum = L[packed(i, i)] * JL[i];
            JINK_UNROLL
            for (int l = i + 1; l < N; ++l) sum = sum + L[packed(l, i)] * JL[l];
            S[packed(i, k)] = i == k ? sum + 1.0 : sum;
        }
    }
}

template <class T, int N> [[gnu::noinline]] void smooth_factor(const T *P, T *L) {
    JINK_UNROLL
    for (int j = 0; j < N; ++j) {
        T pivot = P[packed(j, j)];
        JINK_UNROLL
        for (int k = 0; k < j; ++k) pivot = pivot - L[packed(j, k)] * L[packed(j, k)];
        const T least = larger<T>(2.220446049250313e-16 * P[packed(j, j)], splat<T>(1e-300));
        pivot = select<T>(pivot < least, least, pivot);  // NaN stays
        const T scale = over_root(pivot);
        L[packed(j, j)] = pivot * scale;
        JINK_UNROLL
        for (int i = j + 1; i < N; ++i) {
            T sum = P[packed(i, j)];
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
        const T scale = select<T>(real, over_root(select<T>(real, pivot, splat<T>(1.0))), zero);
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

template <class T, int N> [[gnu::noinline]] void smooth_gram(const T *B, T *J) {
    JINK_UNROLL
    for (int i = 0; i < N; ++i)
        JINK_UNROLL
        for (int j = 0; j <= i; ++j) {
            T sum = B[i] * B[j];
            JINK_UNROLL
            for (int r = 1; r < N; ++r) sum = sum + B[r * N + i] * B[r * N + j];
            J[packed(i, j)] = sum;
        }
}

template <class T, int N> [[gnu::noinline]] void smooth_pull(const T *R, const T *F, T *B) {
    for (int r = 0; r < N; ++r)
        JINK_UNROLL
        for (int j = 0; j < N; ++j) {
            T sum = R[packed(r, r)] * F[r * N + j];
            for (int i = r + 1; i < N; ++i) sum = sum + R[packed(i, r)] * F[i * N + j];
            B[r * N + j] = sum;
        }
}

template <class T, int N> [[gnu::noinline]] T smooth_enter(const T *v, T *B, T &scale) {
    T square = v[0] * v[0];
    JINK_UNROLL
    for (int r = 1; r < N; ++r) square = square + v[r] * v[r];
    const T grown = 1.0 + square, root = square_root(grown);
    scale = 1.0 / (grown + root);
    for (int j = 0; j < N; ++j) {
        T along = v[0] * B[j];
        JINK_UNROLL
        for (int r = 1; r < N; ++r) along = along + v[r] * B[r * N + j];
        along = along * scale;
        JINK_UNROLL
        for (int r = 0; r < N; ++r) B[r * N + j] = B[r * N + j] - v[r] * along;
    }
    return logarithm<T>(grown);
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

template <class T, int N> [[gnu::noinline]] T smooth_hear(const Passage<T> &by, const T *start, T *h) {
    T d[N], c[N], sum[N];
    JINK_UNROLL
    for (int r = 0; r < N; ++r) c[r] = by.c[r];
    if (start) {
        JINK_UNROLL
        for (int k = 0; k < N; ++k) d[k] = start[k] - by.start[k];
        JINK_UNROLL
        for (int r = 0; r < N; ++r)
            JINK_UNROLL
            for (int k = 0; k < N; ++k) c[r] = c[r] - by.B[r * N + k] * d[k];
    }
    T square = c[0] * c[0];
    JINK_UNROLL
    for (int k = 0; k < N; ++k) sum[k] = by.B[k] * c[0];
    JINK_UNROLL
    for (int r = 1; r < N; ++r) {
        square = square + c[r] * c[r];
        JINK_UNROLL
        for (int k = 0; k < N; ++k) sum[k] = sum[k] + by.B[r * N + k] * c[r];
    }
    JINK_UNROLL
    for (int k = 0; k < N; ++k) h[k] = sum[k];
    return by.s - 0.5 * square;
}

// Leaves the upper root of I + L' J L, and u = U^-1 L' h. Returns 1 / det U; the gain is u' u.
template <class T, int N> JINK_INLINE T smooth_whiten(const T *L, const T *J, const T *h, T *U, T *over, T *u, T &gain) {
    T S[packed_size(N)];
    whiten<T, N>(L, J, S);
    const T over_det = upper_root<T, N>(S, U, over);
    JINK_UNROLL
    for (int i = 0; i < N; ++i) {
        u[i] = L[packed(i, i)] * h[i];
        JINK_UNROLL
        for (int l = i + 1; l < N; ++l) u[i] = u[i] + L[packed(l, i)] * h[l];
    }
    solve_upper_root<T, N>(U, over, u);
    gain = u[0] * u[0];
    JINK_UNROLL
    for (int i = 1; i < N; ++i) gain = gain + u[i] * u[i];
    return over_det;
}

template <class T, int N> [[gnu::noinline]] Scaled<T> smooth_fuse(const T *L, const T *J, const T *h, const T *x, T *to, T *P) {
    T U[packed_size(N)], over[N], u[N], gain;
    Scaled<T> mean = scaled<T>(smooth_whiten<T, N>(L, J, h, U, over, u, gain));
    mean.log = mean.log + 0.5 * gain;
    JINK_UNROLL
    for (int i = 0; i < N; ++i) {  // U^-T u
        JINK_UNROLL
        for (int l = 0; l < i; ++l) u[i] = u[i] - U[packed(i, l)] * u[l];
        u[i] = u[i] * over[i];
    }
    JINK_UNROLL
    for (int i = 0; i < N; ++i) {
        T sum = x[i];
        JINK_UNROLL
        for (int k = 0; k <= i; ++k) sum = sum + L[packed(i, k)] * u[k];
        to[i] = sum;
    }
    if (!P) return mean;
    T V[packed_size(N)];
    solve_root<T, N>(U, over, L, V);
    smooth_square<T, N>(V, P);
    return mean;
}

template <class T, int N> [[gnu::noinline]] Scaled<T> smooth_level(const T *L, const T *J, const T *h) {
    T U[packed_size(N)], over[N], u[N], gain;
    Scaled<T> mean = scaled<T>(smooth_whiten<T, N>(L, J, h, U, over, u, gain));
    mean.log = mean.log + 0.5 * gain;
    return mean;
}

// Pair after pair: w_k of them together and their mean x_k, the spread grows by w_(k-1) share_k / w_k d d', d = x of pair k - x_(k-1).
template <class T, int N>
[[gnu::noinline]] void smooth_merge(const SmoothPair<T> *pairs, int count, T *x, T *P, T *J, T *h, T *V) {
    constexpr int size = packed_size(N);
    T mean[N], told[N], M[size], weight = pairs[0].share;
    JINK_UNROLL
    for (int k = 0; k < N; ++k) mean[k] = pairs[0].x[k], told[k] = weight * pairs[0].h[k];
    JINK_UNROLL
    for (int r = 0; r < N; ++r)
        JINK_UNROLL
        for (int q = 0; q <= r; ++q) M[packed(r, q)] = weight * pairs[0].J[packed(r, q)];
    for (int j = 1; j < count; ++j) {
        const SmoothPair<T> &p = pairs[j];
        const T together = weight + p.share, part = p.share * reciprocal(larger<T>(together, splat<T>(1e-300)));
        const T product = weight * part, root = product * over_root(larger<T>(product, splat<T>(1e-300)));
        weight = together;
        JINK_UNROLL
        for (int k = 0; k < N; ++k) {
            const T d = p.x[k] - mean[k];
            V[(j - 1) * N + k] = root * d;
            mean[k] = mean[k] + part * d, told[k] = told[k] + p.share * p.h[k];
        }
        JINK_UNROLL
        for (int r = 0; r < N; ++r)
            JINK_UNROLL
            for (int q = 0; q <= r; ++q) M[packed(r, q)] = M[packed(r, q)] + p.share * p.J[packed(r, q)];
    }
    JINK_UNROLL
    for (int k = 0; k < N; ++k) x[k] = mean[k], h[k] = told[k];
    std::copy_n(M, size, J);
    if (!P) return;
    T C[size];
    JINK_UNROLL
    for (int r = 0; r < N; ++r)
        JINK_UNROLL
        for (int q = 0; q <= r; ++q) C[packed(r, q)] = pairs[0].share * pairs[0].P[packed(r, q)];
    for (int j = 1; j < count; ++j) {
        const T share = pairs[j].share, *v = V + (j - 1) * N;
        JINK_UNROLL
        for (int r = 0; r < N; ++r)
            JINK_UNROLL
            for (int q = 0; q <= r; ++q) C[packed(r, q)] = C[packed(r, q)] + share * pairs[j].P[packed(r, q)] + v[r] * v[q];
    }
    JINK_UNROLL
    for (int k = 0; k < N; ++k) C[packed(k, k)] = C[packed(k, k)] * (1.0 + rounding_share(N));
    std::copy_n(C, size, P);
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

template <class T, int N, int B> SmoothKernels<T> smooth_kernels_of() {
    return {smooth_factor<T, N>, smooth_root<T, N>,   smooth_blur<T, N, B>, smooth_spread<T, N>, smooth_thin<T, N>,
            smooth_gram<T, N>,   smooth_pull<T, N>,   smooth_enter<T, N>,   smooth_listen<T, N>, smooth_hear<T, N>,
            smooth_fuse<T, N>,   smooth_level<T, N>,  smooth_merge<T, N>,   smooth_unsound<T, N>};
}

}  // namespace jink::inline JINK_LEVEL
