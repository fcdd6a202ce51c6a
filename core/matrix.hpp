// Small symmetric matrices, kept as their lower triangle row by row: (0,0) (1,0) (1,1) (2,0) ...
#pragma once

#include "number.hpp"

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

}  // namespace jink::inline JINK_LEVEL
