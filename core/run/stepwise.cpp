#include "run/stepwise.hpp"

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

// Measurements with correlated errors as others with independent ones, R = L D L' with unit lower L: z becomes L^-1 z. Where each
// row looks at one component of its own, so does L^-1 H once the state has lost L's multiples (see Decorrelate in update.hpp):
// the covariance is turned there and back, and nothing cancels. Otherwise H becomes L^-1 H.
class Independent {
  public:
    double variance[largest_own];

    Independent(int n_, int m_, const bool *present, const double *H, const double *R) : n(n_), m(m_), turns(true) {
        for (int r = 0; r < m; ++r) {
            for (int q = 0; q <= r; ++q) {
                double sum = R[r * m + q];
                for (int k = 0; k < q; ++k) sum -= L[r][k] * L[q][k] * variance[k];
                if (q == r) variance[r] = sum > 0.0 || std::isnan(sum) ? sum : 1e-300;
                else L[r][q] = sum / variance[q], full = full || sum != 0.0;
            }
            place[r] = only_one(n, H + r * n);
            slope[r] = place[r] >= 0 ? H[r * n + place[r]] : 1.0;
            turns = turns && (place[r] >= 0 || !present[r]);
            for (int q = 0; q < r; ++q) turns = turns && (place[q] < 0 || place[q] != place[r]);
        }
    }

    void start(double *y, double *H, double *P) const {
        if (!full) return;
        for (int r = 0; r < m; ++r)
            for (int q = 0; q < r; ++q) {
                y[r] -= L[r][q] * y[q];
                for (int k = 0; k < n && !turns; ++k) H[r * n + k] -= L[r][q] * H[q * n + k];
            }
        for (int r = 0; r < m && turns; ++r)
            for (int q = 0; q < r; ++q) add(r, q, -1.0, nullptr, P);
    }

    void finish(double *moved, double *P) const {
        for (int r = m - 1; r >= 0 && full && turns; --r)
            for (int q = r - 1; q >= 0; --q) add(r, q, 1.0, moved, P);
    }

  private:
    int n, m, place[largest_own];
    bool full = false, turns;
    double L[largest_own][largest_own], slope[largest_own];

    void add(int r, int q, double sign, double *x, double *P) const {
        const int to = place[r], from = place[q];
        if (to < 0 || from < 0 || L[r][q] == 0.0) return;
        const double l = sign * L[r][q] * slope[q] / slope[r];
        if (x) x[to] += l * x[from];
        const double corner = P[to * n + to] + l * (2.0 * P[to * n + from] + l * P[from * n + from]);
        for (int i = 0; i < n; ++i)
            if (i != to) P[to * n + i] += l * P[from * n + i], P[i * n + to] = P[to * n + i];
        P[to * n + to] = corner;
    }
};

}  // namespace

void update_own(int n, int m, const bool *present, double *y, double *H, double *R, double *x, double *P, OwnInnovation &v) {
    double moved[largest_own] = {}, c[largest_own];
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
    const Independent errors(n, m, present, H, R);
    errors.start(y, H, P);
    v.nis = 0.0, v.det = 1.0;
    for (int r = 0; r < m; ++r) {
        v.e[r] = 0.0, v.S[r] = 1.0;
        if (!present[r]) continue;
        const double *h = H + r * n;
        double e = y[r], S = errors.variance[r];
        for (int i = 0; i < n; ++i) {
            c[i] = 0.0;
            for (int k = 0; k < n; ++k) c[i] += h[k] * P[i * n + k];
        }
        for (int k = 0; k < n; ++k) S += h[k] * c[k], e -= h[k] * moved[k];
        const double gain = 1.0 / S, kept = errors.variance[r] * gain;
        const int p = only_one(n, h);
        v.nis += gain * e * e, v.det *= S;
        v.e[r] = e, v.S[r] = S;
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
    errors.finish(moved, P);
    for (int i = 0; i < n; ++i) x[i] += moved[i];
}

void root_of(int n, const double *P, bool semidefinite, double least, double *L) {
    std::fill(L, L + n * n, 0.0);
    for (int j = 0; j < n; ++j) {
        double pivot = P[j * n + j];
        for (int k = 0; k < j; ++k) pivot -= L[j * n + k] * L[j * n + k];
        if (semidefinite && !(pivot > rounding_share(n) * P[j * n + j])) continue;
        const double root = std::sqrt(pivot > least || std::isnan(pivot) ? pivot : least);
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
