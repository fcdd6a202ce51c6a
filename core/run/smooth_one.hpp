// Fixed-interval smoothing of one mode: Rauch, Tung & Striebel, AIAA Journal 3(8), 1965.
//
//   C = P F' (P-)^-1 ,  xs = x + C (xs+ - x-) ,  Ps = (I - C F) P (I - C F)' + C (Q + Ps+) C'
//
// The covariance as a sum of squares, so that it stays positive definite.
#pragma once

#include "run/record.hpp"
#include "run/smooth_message.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class SmoothOne {
  public:
    explicit SmoothOne(const Composition<T> &composition) : mode(composition.modes[0]), forward(composition) {}

    // `after` holds the smoothed x and packed P of the scan after; they become those of this scan.
    void step(const Record<T> &now, const Record<T> &next, T *after) {
        constexpr int L = largest_state;
        const int n = mode.shape.n;
        const T *x = &now.arena[mode.place], *P = x + n;
        T ahead[L], F[L * L], Q[packed_size(L)], FP[L * L], P_ahead[packed_size(L)] = {}, chol[packed_size(L)], C[L * L], G[L * L];
        forward.elapse(select<T>(next.linked, next.dt, splat<T>(0.0)));
        mode.kernels.linearise(x, next.coefficients.empty() ? forward.coefficient(0) : next.coefficients.data(), next.input_of(0), ahead, F, Q);
        if (forward.coast.active()) forward.coast(mode, select<T>(next.linked, next.dt, splat<T>(0.0)), next.coasted, x, ahead);
        for (int r = 0; r < n; ++r)
            for (int k = 0; k < n; ++k) {
                FP[r * n + k] = splat<T>(0.0);
                for (int l = 0; l < n; ++l) FP[r * n + k] = FP[r * n + k] + F[r * n + l] * P[packed(l, k)];
            }
        for (int r = 0; r < n; ++r)
            for (int k = 0; k <= r; ++k) {
                T sum = Q[packed(r, k)];
                for (int l = 0; l < n; ++l) sum = sum + FP[r * n + l] * F[k * n + l];
                P_ahead[packed(r, k)] = r == k ? sum * (1.0 + rounding_share(n)) : sum;
            }
        cholesky<T>(n, P_ahead, chol);
        for (int r = 0; r < n; ++r) {
            T *row = C + r * n;
            for (int k = 0; k < n; ++k) row[k] = FP[k * n + r];
            solve_lower<T>(n, chol, row);
            solve_upper<T>(n, chol, row);
        }
        for (int r = 0; r < n; ++r)
            for (int q = 0; q < n; ++q) {
                G[r * n + q] = splat<T>(r == q ? 1.0 : 0.0);
                for (int k = 0; k < n; ++k) G[r * n + q] = G[r * n + q] - C[r * n + k] * F[k * n + q];
            }
        T xs[L], Ps[packed_size(L)], noise[packed_size(L)];
        for (int k = 0; k < packed_size(n); ++k) noise[k] = Q[k] + after[n + k], Ps[k] = splat<T>(0.0);
        for (int r = 0; r < n; ++r) {
            xs[r] = x[r];
            for (int k = 0; k < n; ++k) xs[r] = xs[r] + C[r * n + k] * (after[k] - ahead[k]);
        }
        add_congruence(n, n, G, P, Ps);
        add_congruence(n, n, C, noise, Ps);
        for (int r = 0; r < n; ++r) {  // what the sums above may have lost to rounding, from above
            T reach = splat<T>(0.0);
            for (int k = 0; k < n; ++k)
                reach = reach + magnitude(G[r * n + k]) * square_root(P[packed(k, k)]) + magnitude(C[r * n + k]) * square_root(noise[packed(k, k)]);
            Ps[packed(r, r)] = Ps[packed(r, r)] + rounding_share(n) * reach * reach;
        }
        T sum = splat<T>(0.0);
        for (int k = 0; k < n; ++k) sum = sum + (xs[k] * to_farthest) * 0.0 + (Ps[packed(k, k)] * to_least_certain) * 0.0;
        for (int k = 0; k < packed_size(n); ++k) sum = sum + (Ps[k] - Ps[k]);
        const Mask<T> smoothed = next.linked & inverse(is_nan(sum));  // beyond all range the filtered estimate stays
        for (int k = 0; k < n; ++k) after[k] = select<T>(smoothed, xs[k], x[k]);
        for (int k = 0; k < packed_size(n); ++k) after[n + k] = select<T>(smoothed, Ps[k], P[k]);
    }

  private:
    const Mode<T> &mode;
    Propagate<T> forward;
};

}  // namespace jink::inline JINK_LEVEL
