// The arithmetic of the smoother of several modes, unrolled for each size of state.
//
// A message is log p(Z_future | x) = s + h' e - 1/2 e' J e with e = x - x_0, or, with J = R R' (R lower triangular) and h = R g,
//
//   s + 1/2 g' g - 1/2 |g - R' e|^2
//
// A root is taken once per mode; noise and the fusion with an estimate then leave triangles triangular: I + R' Q R = U U' with an
// upper triangular U, and U^-1 R' is upper triangular as well. Sums of squares only: nothing large is subtracted.
#pragma once

#include "number/matrix.hpp"
#include "scan/composition.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> struct SmoothKernels {
    // P = L L'.
    void (*factor)(const T *P, T *L);
    // J = R R' of a semidefinite J, and h = R g.
    void (*root)(const T *J, const T *h, T *R, T *g);
    // R and g of the message before noise of covariance Q; log det (I + R' Q R).
    T (*blur)(const T *Q, T *R, T *g);
    // The same for noise of covariance V V', V column after column.
    T (*blur_by_columns)(const T *V, int columns, T *R, T *g);
    // J = R R' and h = R g again.
    void (*square)(const T *R, const T *g, T *J, T *h);
    // J = B' B, B row by row.
    void (*gram)(const T *B, T *J);
    // B = R' F for a full F.
    void (*pull)(const T *R, const T *F, T *B);
    // c = g - R' d.
    void (*move)(const T *R, const T *g, const T *d, T *c);
    // B <- (I + v v')^-1/2 B = (I - scale v v') B; log (1 + v' v).
    T (*enter)(const T *v, T *B, T &scale);
    // h = B' c; c' c.
    T (*hear)(const T *B, const T *c, T *h);
    // (P^-1 + J)^-1, the way from its mean to that of P = L L', the message's gain h' x; log det (I + L' J L).
    T (*fuse)(const T *L, const T *J, const T *h, T *x, T *P, T &gain);
    // Of that the gain and the determinant alone.
    T (*level)(const T *L, const T *J, const T *h, T &gain);
};

// S = U U' with an upper triangular U, kept as the lower triangle of U'. Pivots are at least one, because S - I is semidefinite.
// Returns det U; `over` gets the reciprocals of the diagonal.
template <class T, int N> JINK_INLINE T upper_root(const T *S, T *U, T *over) {
    T det = splat<T>(1.0);
    JINK_UNROLL
    for (int j = N - 1; j >= 0; --j) {
        T pivot = S[packed(j, j)];
        JINK_UNROLL
        for (int k = N - 1; k > j; --k) pivot = pivot - U[packed(k, j)] * U[packed(k, j)];
        pivot = select<T>(pivot < splat<T>(1.0), splat<T>(1.0), pivot);  // NaN stays
        over[j] = reciprocal_root(pivot);
        det = det * (pivot * over[j]);
        JINK_UNROLL
        for (int i = 0; i < j; ++i) {
            T sum = S[packed(j, i)];
            JINK_UNROLL
            for (int k = N - 1; k > j; --k) sum = sum - U[packed(k, i)] * U[packed(k, j)];
            U[packed(j, i)] = sum * over[j];
        }
    }
    return det;
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
        const T scale = reciprocal_root(pivot);
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

// A pivot lost in rounding leaves its column, and its g, zero; h has nothing there.
template <class T, int N> [[gnu::noinline]] void smooth_root(const T *J, const T *h, T *R, T *g) {
    const T zero = splat<T>(0.0);
    T rest[N];
    JINK_UNROLL
    for (int i = 0; i < N; ++i) rest[i] = h[i];
    JINK_UNROLL
    for (int j = 0; j < N; ++j) {
        T pivot = J[packed(j, j)];
        JINK_UNROLL
        for (int k = 0; k < j; ++k) pivot = pivot - R[packed(j, k)] * R[packed(j, k)];
        const Mask<T> real = pivot > rounding_share(N) * J[packed(j, j)];
        const T scale = select<T>(real, reciprocal_root(select<T>(real, pivot, splat<T>(1.0))), zero);
        R[packed(j, j)] = select<T>(real, pivot * scale, zero);
        g[j] = rest[j] * scale;
        JINK_UNROLL
        for (int i = j + 1; i < N; ++i) {
            T sum = J[packed(i, j)];
            JINK_UNROLL
            for (int k = 0; k < j; ++k) sum = sum - R[packed(i, k)] * R[packed(j, k)];
            R[packed(i, j)] = sum * scale;
            rest[i] = rest[i] - R[packed(i, j)] * g[j];
        }
    }
}

// Components that process noise couples: those of a block of B, one axis of the state; a turn rate is by itself.
template <int N, int B> constexpr bool coupled(int i, int j) { return i / B == j / B; }

template <class T, int N, int B> [[gnu::noinline]] T smooth_blur(const T *Q, T *R, T *g) {
    T S[packed_size(N)], U[packed_size(N)], over[N], W[packed_size(N)];
    JINK_UNROLL
    for (int k = 0; k < N; ++k) {
        T QR[N];
        JINK_UNROLL
        for (int i = k / B * B; i < N; ++i) {
            T sum = splat<T>(0.0);
            bool any_yet = false;
            JINK_UNROLL
            for (int l = 0; l < N; ++l) {
                if (l < k || !coupled<N, B>(i, l)) continue;
                sum = any_yet ? sum + Q[packed(i, l)] * R[packed(l, k)] : Q[packed(i, l)] * R[packed(l, k)];
                any_yet = true;
            }
            QR[i] = sum;
        }
        JINK_UNROLL
        for (int i = k; i < N; ++i) {
            T sum = R[packed(i, i)] * QR[i];
            JINK_UNROLL
            for (int l = i + 1; l < N; ++l) sum = sum + R[packed(l, i)] * QR[l];
            S[packed(i, k)] = i == k ? sum + 1.0 : sum;
        }
    }
    const T det = upper_root<T, N>(S, U, over);
    solve_root<T, N>(U, over, R, W);
    solve_upper_root<T, N>(U, over, g);
    JINK_UNROLL
    for (int k = 0; k < packed_size(N); ++k) R[k] = W[k];
    return 2.0 * logarithm<T>(det);
}

template <class T, int N> [[gnu::noinline]] T smooth_blur_by_columns(const T *V, int columns, T *R, T *g) {
    T S[packed_size(N)], U[packed_size(N)], over[N], W[packed_size(N)];
    JINK_UNROLL
    for (int i = 0; i < N; ++i)
        JINK_UNROLL
        for (int k = 0; k <= i; ++k) S[packed(i, k)] = splat<T>(i == k ? 1.0 : 0.0);
    for (int c = 0; c < columns; ++c) {
        T v[N];
        JINK_UNROLL
        for (int i = 0; i < N; ++i) {
            v[i] = R[packed(i, i)] * V[c * N + i];
            JINK_UNROLL
            for (int l = i + 1; l < N; ++l) v[i] = v[i] + R[packed(l, i)] * V[c * N + l];
        }
        JINK_UNROLL
        for (int i = 0; i < N; ++i)
            JINK_UNROLL
            for (int k = 0; k <= i; ++k) S[packed(i, k)] = S[packed(i, k)] + v[i] * v[k];
    }
    const T det = upper_root<T, N>(S, U, over);
    solve_root<T, N>(U, over, R, W);
    solve_upper_root<T, N>(U, over, g);
    JINK_UNROLL
    for (int k = 0; k < packed_size(N); ++k) R[k] = W[k];
    return 2.0 * logarithm<T>(det);
}

template <class T, int N> [[gnu::noinline]] void smooth_square(const T *R, const T *g, T *J, T *h) {
    JINK_UNROLL
    for (int i = 0; i < N; ++i) {
        T sum = R[packed(i, 0)] * g[0];
        JINK_UNROLL
        for (int k = 1; k <= i; ++k) sum = sum + R[packed(i, k)] * g[k];
        h[i] = sum;
        JINK_UNROLL
        for (int j = 0; j <= i; ++j) {
            T square = R[packed(i, 0)] * R[packed(j, 0)];
            JINK_UNROLL
            for (int k = 1; k <= j; ++k) square = square + R[packed(i, k)] * R[packed(j, k)];
            J[packed(i, j)] = square;
        }
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

template <class T, int N> [[gnu::noinline]] void smooth_move(const T *R, const T *g, const T *d, T *c) {
    JINK_UNROLL
    for (int i = 0; i < N; ++i) {
        T sum = g[i];
        JINK_UNROLL
        for (int k = i; k < N; ++k) sum = sum - R[packed(k, i)] * d[k];
        c[i] = sum;
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

template <class T, int N> [[gnu::noinline]] T smooth_hear(const T *B, const T *c, T *h) {
    T square = c[0] * c[0], sum[N];
    JINK_UNROLL
    for (int k = 0; k < N; ++k) sum[k] = B[k] * c[0];
    JINK_UNROLL
    for (int r = 1; r < N; ++r) {
        square = square + c[r] * c[r];
        JINK_UNROLL
        for (int k = 0; k < N; ++k) sum[k] = sum[k] + B[r * N + k] * c[r];
    }
    JINK_UNROLL
    for (int k = 0; k < N; ++k) h[k] = sum[k];
    return square;
}

template <class T, int N> JINK_INLINE T smooth_whiten(const T *L, const T *J, const T *h, T *U, T *over, T *u, T &gain) {
    T S[packed_size(N)];
    whiten<T, N>(L, J, S);
    const T det = upper_root<T, N>(S, U, over);
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
    return 2.0 * logarithm<T>(det);
}

template <class T, int N> [[gnu::noinline]] T smooth_fuse(const T *L, const T *J, const T *h, T *x, T *P, T &gain) {
    T U[packed_size(N)], over[N], u[N], V[packed_size(N)];
    const T log_det = smooth_whiten<T, N>(L, J, h, U, over, u, gain);
    solve_root<T, N>(U, over, L, V);
    smooth_square<T, N>(V, u, P, x);
    return log_det;
}

template <class T, int N> [[gnu::noinline]] T smooth_level(const T *L, const T *J, const T *h, T &gain) {
    T U[packed_size(N)], over[N], u[N];
    return smooth_whiten<T, N>(L, J, h, U, over, u, gain);
}

template <class T, int N, int B> SmoothKernels<T> smooth_kernels_of() {
    return {smooth_factor<T, N>, smooth_root<T, N>,  smooth_blur<T, N, B>, smooth_blur_by_columns<T, N>, smooth_square<T, N>, smooth_gram<T, N>,
            smooth_pull<T, N>,   smooth_move<T, N>,  smooth_enter<T, N>,   smooth_hear<T, N>,            smooth_fuse<T, N>,   smooth_level<T, N>};
}

// For the states of a shape; `full` where the noise couples all components.
template <class T> SmoothKernels<T> smooth_kernels(const StateShape &shape, bool full);

}  // namespace jink::inline JINK_LEVEL
