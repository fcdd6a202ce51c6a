// Small symmetric matrices, kept as their lower triangle row by row: (0,0) (1,0) (1,1) (2,0) ...
#pragma once

#include <algorithm>

#include "number/elementary.hpp"

namespace jink::inline JINK_LEVEL {

constexpr int packed(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }
constexpr int packed_size(int n) { return n * (n + 1) / 2; }
inline constexpr int largest_state = 10;
inline constexpr int largest_measurement = 6;

// Rounding leaves an error of a few eps * sqrt(P_ii P_jj) in each element of a covariance. Adding this share to the
// diagonal bounds it from above (Gershgorin on the scaled matrix), so a covariance stays positive definite by
// construction through updates that subtract.
constexpr double rounding_share(int n) { return 4.0 * n * 2.220446049250313e-16; }

// Whether all lanes of 2 x 2 or 3 x 3 hold a covariance that rounding leaves definite, by its minors; NaN does not.
template <class T> inline bool surely_definite(int n, const T *P) {
    const double share = 2.0 * rounding_share(n);
    const T most = n == 2 ? larger<T>(P[0], P[2]) : larger<T>(larger<T>(P[0], P[2]), P[5]);
    const T minor = P[0] * P[2] - P[1] * P[1];
    Mask<T> sure = (P[0] > share * most) & (P[2] > share * most) & (minor > share * (P[0] * P[2]));
    if (n == 3) {
        const T whole = P[5] * minor - P[3] * (P[3] * P[2] - P[4] * P[1]) - P[4] * (P[4] * P[0] - P[3] * P[1]);
        sure = sure & (P[5] > share * most) & (whole > share * (P[5] * minor));
    }
    return !any(inverse(sure));
}

// A symmetric matrix that is not a covariance becomes one, in place: variances stay, but none is less than what rounding leaves of
// the largest; correlations beyond one are cut to what the variances allow. Lanes that hold a covariance are left as they are.
template <class T> [[gnu::noinline]] void make_definite(int n, T *P) {
    if ((n == 2 || n == 3) && surely_definite(n, P)) return;
    const double share = rounding_share(n);
    T most = splat<T>(1e-300), L[packed_size(largest_measurement)], made[packed_size(largest_measurement)];
    for (int i = 0; i < n; ++i) most = larger<T>(most, P[packed(i, i)]);
    Mask<T> lost = splat_mask<T>(false);
    for (int j = 0; j < n; ++j) {
        const T variance = larger<T>(P[packed(j, j)], share * most);
        T pivot = variance;
        for (int k = 0; k < j; ++k) pivot = pivot - L[packed(j, k)] * L[packed(j, k)];
        lost = lost | (P[packed(j, j)] < share * most) | (pivot < share * variance);
        pivot = larger<T>(pivot, share * variance);
        L[packed(j, j)] = square_root(pivot);
        for (int i = j + 1; i < n; ++i) {
            T sum = P[packed(i, j)], left = larger<T>(P[packed(i, i)], share * most);
            for (int k = 0; k < j; ++k) sum = sum - L[packed(i, k)] * L[packed(j, k)], left = left - L[packed(i, k)] * L[packed(i, k)];
            const T reach = square_root(larger<T>(left, splat<T>(0.0)));
            L[packed(i, j)] = larger<T>(smaller<T>(sum / L[packed(j, j)], reach), -reach);
        }
    }
    if (!any(lost)) return;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j) {
            T sum = L[packed(i, 0)] * L[packed(j, 0)];
            for (int k = 1; k <= j; ++k) sum = sum + L[packed(i, k)] * L[packed(j, k)];
            made[packed(i, j)] = sum;
        }
    for (int k = 0; k < packed_size(n); ++k) P[k] = select<T>(lost, made[k], P[k]);
}

// P = L L' for the lower triangle, n at run time. A pivot that rounding has eaten up is replaced by what rounding leaves at the least.
template <class T> inline void cholesky(int n, const T *P, T *L) {
    for (int j = 0; j < n; ++j) {
        T pivot = P[packed(j, j)];
        for (int k = 0; k < j; ++k) pivot = pivot - L[packed(j, k)] * L[packed(j, k)];
        const T least = larger<T>(2.220446049250313e-16 * P[packed(j, j)], splat<T>(1e-300));
        pivot = select<T>(pivot > least, pivot, select<T>(is_nan(pivot), pivot, least));
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
template <class T, int N> [[gnu::noinline]] void add_congruence_of(int r, const T *A, const T *P, T *out) {
    for (int i = 0; i < r; ++i) {
        T row[N];
        for (int k = 0; k < N; ++k) {
            row[k] = A[i * N] * P[packed(0, k)];
            for (int l = 1; l < N; ++l) row[k] = row[k] + A[i * N + l] * P[packed(l, k)];
        }
        for (int j = 0; j <= i; ++j) {
            T sum = out[packed(i, j)];
            for (int k = 0; k < N; ++k) sum = sum + row[k] * A[j * N + k];
            out[packed(i, j)] = sum;
        }
    }
}

template <class T> inline void add_congruence(int r, int n, const T *A, const T *P, T *out) {
    switch (n) {
        case 2: return add_congruence_of<T, 2>(r, A, P, out);
        case 3: return add_congruence_of<T, 3>(r, A, P, out);
        case 4: return add_congruence_of<T, 4>(r, A, P, out);
        case 5: return add_congruence_of<T, 5>(r, A, P, out);
        case 6: return add_congruence_of<T, 6>(r, A, P, out);
        case 7: return add_congruence_of<T, 7>(r, A, P, out);
        default: return add_congruence_of<T, 9>(r, A, P, out);
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

// (P^-1 + J)^-1 = L (I + L' J L)^-1 L' = W' W with P = L L', C C' = I + L' J L and W = C^-1 L': positive definite by construction.
// Both may be semidefinite: with the roles changed it is also (J^-1 + Q)^-1. Returns log det C C'; W (n by n) and C if wanted.
template <class T, int N>
[[gnu::noinline]] T parallel_sum_of(const T *L, const T *J, T *out, T *W_out, T *C_out) {
    constexpr int size = packed_size(N);
    T JL[N * N], inner[size], C[size], W[N * N];
    for (int i = 0; i < N; ++i)
        for (int k = 0; k < N; ++k) {
            T sum = J[packed(i, k)] * L[packed(k, k)];
            for (int l = k + 1; l < N; ++l) sum = sum + J[packed(i, l)] * L[packed(l, k)];
            JL[i * N + k] = sum;
        }
    for (int i = 0; i < N; ++i)
        for (int k = 0; k <= i; ++k) {
            T sum = L[packed(i, i)] * JL[i * N + k];
            for (int l = i + 1; l < N; ++l) sum = sum + L[packed(l, i)] * JL[l * N + k];
            inner[packed(i, k)] = i == k ? sum + 1.0 : sum;
        }
    T det = splat<T>(1.0), over[N];
    for (int j = 0; j < N; ++j) {
        T pivot = inner[packed(j, j)];
        for (int k = 0; k < j; ++k) pivot = pivot - C[packed(j, k)] * C[packed(j, k)];
        pivot = select<T>(pivot > splat<T>(1.0), pivot, select<T>(is_nan(pivot), pivot, splat<T>(1.0)));  // at least one
        over[j] = reciprocal_root(pivot);
        C[packed(j, j)] = pivot * over[j];
        det = det * C[packed(j, j)];
        for (int i = j + 1; i < N; ++i) {
            T sum = inner[packed(i, j)];
            for (int k = 0; k < j; ++k) sum = sum - C[packed(i, k)] * C[packed(j, k)];
            C[packed(i, j)] = sum * over[j];
        }
    }
    for (int k = 0; k < N; ++k)  // column k of L' ends at row k
        for (int i = 0; i < N; ++i) {
            T sum = i <= k ? L[packed(k, i)] : splat<T>(0.0);
            for (int l = 0; l < i; ++l) sum = sum - C[packed(i, l)] * W[l * N + k];
            W[i * N + k] = sum * over[i];
        }
    for (int i = 0; i < N; ++i)
        for (int j = 0; j <= i; ++j) {
            T sum = W[i] * W[j];
            for (int k = 1; k < N; ++k) sum = sum + W[k * N + i] * W[k * N + j];
            out[packed(i, j)] = sum;
        }
    if (W_out) std::memcpy(W_out, W, sizeof W);
    if (C_out) std::memcpy(C_out, C, sizeof C);
    return 2.0 * logarithm<T>(det);
}

template <class T> inline T parallel_sum(int n, const T *L, const T *J, T *out, T *W = nullptr, T *C = nullptr) {
    switch (n) {
        case 2: return parallel_sum_of<T, 2>(L, J, out, W, C);
        case 3: return parallel_sum_of<T, 3>(L, J, out, W, C);
        case 4: return parallel_sum_of<T, 4>(L, J, out, W, C);
        case 5: return parallel_sum_of<T, 5>(L, J, out, W, C);
        case 6: return parallel_sum_of<T, 6>(L, J, out, W, C);
        case 7: return parallel_sum_of<T, 7>(L, J, out, W, C);
        default: return parallel_sum_of<T, 9>(L, J, out, W, C);
    }
}

}  // namespace jink::inline JINK_LEVEL
