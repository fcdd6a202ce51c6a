// Small symmetric matrices, kept as their lower triangle row by row: (0,0) (1,0) (1,1) (2,0) ...
#pragma once

#include "elementary.hpp"

namespace jink::inline JINK_LEVEL {

constexpr int packed(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }
constexpr int packed_size(int n) { return n * (n + 1) / 2; }
inline constexpr int largest_state = 10;
inline constexpr int largest_measurement = 6;

// Rounding leaves an error of a few eps * sqrt(P_ii P_jj) in each element of a covariance. Adding this share to the
// diagonal bounds it from above (Gershgorin on the scaled matrix), so a covariance stays positive definite by
// construction through updates that subtract.
constexpr double rounding_share(int n) { return 4.0 * n * 2.220446049250313e-16; }

// P = L L' for the lower triangle, n at run time. A pivot that is not positive is replaced by the smallest normal number.
template <class T> inline void cholesky(int n, const T *P, T *L) {
    for (int j = 0; j < n; ++j) {
        T pivot = P[packed(j, j)];
        for (int k = 0; k < j; ++k) pivot = pivot - L[packed(j, k)] * L[packed(j, k)];
        pivot = select<T>(pivot > splat<T>(0.0), pivot, select<T>(is_nan(pivot), pivot, splat<T>(1e-300)));
        const T root = square_root(pivot), scale = 1.0 / root;
        L[packed(j, j)] = root;
        for (int i = j + 1; i < n; ++i) {
            T sum = P[packed(i, j)];
            for (int k = 0; k < j; ++k) sum = sum - L[packed(i, k)] * L[packed(j, k)];
            L[packed(i, j)] = sum * scale;
        }
    }
}

// L b = y, in place.
template <class T> inline void solve_lower(int n, const T *L, T *y) {
    for (int i = 0; i < n; ++i) {
        T sum = y[i];
        for (int k = 0; k < i; ++k) sum = sum - L[packed(i, k)] * y[k];
        y[i] = sum / L[packed(i, i)];
    }
}

// L' b = y, in place.
template <class T> inline void solve_upper(int n, const T *L, T *y) {
    for (int i = n - 1; i >= 0; --i) {
        T sum = y[i];
        for (int k = i + 1; k < n; ++k) sum = sum - L[packed(k, i)] * y[k];
        y[i] = sum / L[packed(i, i)];
    }
}

// out += A P A' for a row-major A of r by n, the results and P packed.
template <class T> inline void add_congruence(int r, int n, const T *A, const T *P, T *out) {
    T row[largest_state];
    for (int i = 0; i < r; ++i) {
        for (int k = 0; k < n; ++k) {
            row[k] = A[i * n] * P[packed(0, k)];
            for (int l = 1; l < n; ++l) row[k] = row[k] + A[i * n + l] * P[packed(l, k)];
        }
        for (int j = 0; j <= i; ++j) {
            T sum = out[packed(i, j)];
            for (int k = 0; k < n; ++k) sum = sum + row[k] * A[j * n + k];
            out[packed(i, j)] = sum;
        }
    }
}

// J = L L' of a positive semidefinite J: a pivot lost in rounding leaves its column zero.
template <class T> inline void semidefinite_cholesky(int n, const T *J, T *L) {
    const T zero = splat<T>(0.0);
    for (int j = 0; j < n; ++j) {
        T pivot = J[packed(j, j)];
        for (int k = 0; k < j; ++k) pivot = pivot - L[packed(j, k)] * L[packed(j, k)];
        const Mask<T> real = pivot > rounding_share(n) * J[packed(j, j)];
        const T root = square_root(select<T>(real, pivot, splat<T>(1.0)));
        const T scale = select<T>(real, 1.0 / root, zero);
        L[packed(j, j)] = select<T>(real, root, zero);
        for (int i = j + 1; i < n; ++i) {
            T sum = J[packed(i, j)];
            for (int k = 0; k < j; ++k) sum = sum - L[packed(i, k)] * L[packed(j, k)];
            L[packed(i, j)] = sum * scale;
        }
    }
}

// (P^-1 + J)^-1 = L (I + L' J L)^-1 L' with P = L L', positive definite by construction; returns log det(I + P J).
// Both may be semidefinite: with the roles changed it is also (J^-1 + Q)^-1.
template <class T> inline T parallel_sum(int n, const T *L, const T *J, T *out) {
    constexpr int N = largest_state;
    T A[N * N], inner[packed_size(N)], chol[packed_size(N)];
    for (int i = 0; i < n; ++i)  // A = L'
        for (int k = 0; k < n; ++k) A[i * n + k] = k >= i ? L[packed(k, i)] : splat<T>(0.0);
    for (int k = 0; k < packed_size(n); ++k) inner[k] = splat<T>(0.0);
    for (int i = 0; i < n; ++i) inner[packed(i, i)] = splat<T>(1.0);
    add_congruence(n, n, A, J, inner);
    cholesky<T>(n, inner, chol);
    T det = splat<T>(1.0), column[N];
    for (int i = 0; i < n; ++i) det = det * chol[packed(i, i)];
    for (int k = 0; k < n; ++k) {  // W = C^-1 L'
        for (int i = 0; i < n; ++i) column[i] = A[i * n + k];
        solve_lower<T>(n, chol, column);
        for (int i = 0; i < n; ++i) A[i * n + k] = column[i];
    }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j) {
            T sum = splat<T>(0.0);
            for (int k = 0; k < n; ++k) sum = sum + A[k * n + i] * A[k * n + j];
            out[packed(i, j)] = sum;
        }
    return 2.0 * logarithm<T>(det);
}

}  // namespace jink::inline JINK_LEVEL
