#include "stepwise.hpp"

#include <algorithm>

namespace jink::inline JINK_LEVEL {

void mix_estimates(int modes, int n, const double *const *x, const double *const *P, const double *w, double *x0, double *P0) {
    std::fill(x0, x0 + n, 0.0);
    std::fill(P0, P0 + n * n, 0.0);
    for (int i = 0; i < modes; ++i)
        for (int c = 0; c < n; ++c) x0[c] += w[i] * x[i][c];
    for (int i = 0; i < modes; ++i)
        for (int r = 0; r < n; ++r) {
            const double wd = w[i] * (x[i][r] - x0[r]);
            for (int c = 0; c <= r; ++c) P0[r * n + c] += w[i] * P[i][r * n + c] + wd * (x[i][c] - x0[c]);
        }
    for (int r = 0; r < n; ++r)
        for (int c = 0; c < r; ++c) P0[c * n + r] = P0[r * n + c];
}

namespace {

// L^-1 y, L^-1 H with R = L L'; the whitened noise is one. scale: the diagonal of L. Nothing where R is diagonal.
void whiten(int n, int m, double *y, double *H, const double *R, double *variance, double *scale) {
    bool full = false;
    for (int r = 0; r < m; ++r) {
        variance[r] = R[r * m + r], scale[r] = 1.0;
        for (int q = 0; q < r; ++q) full = full || R[r * m + q] != 0.0;
    }
    if (!full) return;
    double L[largest_own * largest_own];
    root_of(m, R, false, L);
    solve_own(m, 1, L, false, y);
    solve_own(m, n, L, false, H);
    for (int r = 0; r < m; ++r) variance[r] = 1.0, scale[r] = L[r * m + r];
}

// The place of the only component a row looks at, or -1.
int only_one(int n, const double *h) {
    int found = -1;
    for (int k = 0; k < n; ++k)
        if (h[k] != 0.0) {
            if (found >= 0) return -1;
            found = k;
        }
    return found;
}

}  // namespace

void update_own(int n, int m, const bool *present, double *y, double *H, double *R, double *x, double *P, OwnInnovation &v) {
    double variance[largest_own], scale[largest_own], moved[largest_own] = {}, c[largest_own];
    for (int r = 0; r < m; ++r) {
        if (!present[r]) y[r] = 0.0, std::fill(H + r * n, H + (r + 1) * n, 0.0);
        for (int q = 0; q < m; ++q)
            if (!present[r] || !present[q]) R[r * m + q] = q == r ? 1.0 : 0.0;
    }
    for (int r = 0; r < m; ++r) {
        for (int i = 0; i < n; ++i) {
            c[i] = 0.0;
            for (int k = 0; k < n; ++k) c[i] += H[r * n + k] * P[i * n + k];
        }
        for (int q = 0; q <= r; ++q) {
            double S = R[r * m + q];
            for (int k = 0; k < n; ++k) S += H[q * n + k] * c[k];
            v.joint[r * m + q] = v.joint[q * m + r] = S;
        }
    }
    whiten(n, m, y, H, R, variance, scale);
    v.nis = 0.0, v.det = 1.0;
    for (int r = 0; r < m; ++r) {
        v.e[r] = 0.0, v.S[r] = 1.0;
        if (!present[r]) continue;
        const double *h = H + r * n;
        double e = y[r], S = variance[r];
        for (int i = 0; i < n; ++i) {
            c[i] = 0.0;
            for (int k = 0; k < n; ++k) c[i] += h[k] * P[i * n + k];
        }
        for (int k = 0; k < n; ++k) S += h[k] * c[k], e -= h[k] * moved[k];
        const double gain = 1.0 / S, kept = variance[r] * gain;
        const int p = only_one(n, h);
        v.nis += gain * e * e, v.det *= S * scale[r] * scale[r];
        v.e[r] = e * scale[r], v.S[r] = S * scale[r] * scale[r];
        for (int i = 0; i < n; ++i) {
            moved[i] += c[i] * gain * e;
            for (int j = 0; j <= i; ++j) {
                double &Pij = P[i * n + j];
                if (i == p || j == p) Pij *= kept;
                else Pij = (i == j ? Pij * (1.0 + rounding_share(n)) : Pij) - c[i] * gain * c[j];
                P[j * n + i] = Pij;
            }
        }
    }
    for (int i = 0; i < n; ++i) x[i] += moved[i];
}

void root_of(int n, const double *P, bool semidefinite, double *L) {
    std::fill(L, L + n * n, 0.0);
    for (int j = 0; j < n; ++j) {
        double pivot = P[j * n + j];
        for (int k = 0; k < j; ++k) pivot -= L[j * n + k] * L[j * n + k];
        if (semidefinite && !(pivot > rounding_share(n) * P[j * n + j])) continue;
        const double root = std::sqrt(pivot > 0.0 || std::isnan(pivot) ? pivot : 1e-300);
        L[j * n + j] = root;
        for (int i = j + 1; i < n; ++i) {
            double sum = P[i * n + j];
            for (int k = 0; k < j; ++k) sum -= L[i * n + k] * L[j * n + k];
            L[i * n + j] = sum / root;
        }
    }
}

void solve_own(int n, int k, const double *L, bool transposed, double *X) {
    for (int s = 0; s < n; ++s) {
        const int i = transposed ? n - 1 - s : s;
        for (int c = 0; c < k; ++c) {
            double sum = X[i * k + c];
            for (int t = 0; t < s; ++t) {
                const int j = transposed ? n - 1 - t : t;
                sum -= (transposed ? L[j * n + i] : L[i * n + j]) * X[j * k + c];
            }
            X[i * k + c] = sum / L[i * n + i];
        }
    }
}

}  // namespace jink::inline JINK_LEVEL
