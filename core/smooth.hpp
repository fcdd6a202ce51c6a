// Backward smoothing of a filtered stretch: Rauch-Tung-Striebel for one mode, its mixture form for several.
//
// For every pair (mode i at k, mode j at k+1) a Rauch-Tung-Striebel step takes mode i's filtered estimate to mode j's
// smoothed one; the pairs of a mode i are then matched to one Gaussian. A pair weighs
//
//   p(i, j | Z) = p(j | Z) Pi_ij mu_i N(xs_j; x-_ij, P-_ij) / sum_i (the same)
//
// that is, the smoothed state of k+1 says which mode it came from.
// Kim, Journal of Econometrics 60, 1994 (without the Gaussian); Barber, JMLR 7, 2006; Nadarajah et al., IET RSN 2012.
#pragma once

#include <algorithm>

#include "step.hpp"

namespace jink::inline JINK_LEVEL {

// What the forward pass leaves behind of one scan.
template <class T> struct Record {
    std::vector<T> arena, probability;
    T dt, input[3];
    bool has_input;
    Mask<T> started, linked;  // has a state; it follows from the scan before
};

template <class T>
void record(const TrackState<T> &s, const Scan<T> &scan, const Outcome<T> &o, T before, int axes, Record<T> &r) {
    r.arena = s.arena, r.probability = s.probability;
    r.dt = s.time - before;
    r.has_input = scan.input != nullptr;
    for (int a = 0; a < axes && r.has_input; ++a) r.input[a] = scan.input[a];
    r.started = s.started;
    // a start has no past, but the second point of a two-point start has
    const Mask<T> begun = (o.initialised & (s.first_time == s.time)) | o.restarted;
    r.linked = scan.active & s.started & inverse(begun);
}

template <class T> class Smooth {
  public:
    explicit Smooth(const Composition<T> &composition) : c(composition), forward(composition), back(composition.count * composition.count) {
        arena.resize(c.arena_size), probability.resize(c.count), next_arena.resize(c.arena_size), next_probability.resize(c.count);
        log_weight.resize(c.count * c.count);
    }

    std::vector<T> arena, probability;  // the smoothed modes of the current scan

    void last(const Record<T> &record) { arena = record.arena, probability = record.probability; }

    // From the scan after, whose smoothed modes are in `arena`, back to this one.
    void step(const Record<T> &now, const Record<T> &after) {
        arena.swap(next_arena), probability.swap(next_probability);
        forward.elapse(select<T>(after.linked, after.dt, splat<T>(0.0)));
        const int m = c.count;
        for (int j = 0; j < m; ++j)
            for (int i = 0; i < m; ++i) pair(now, after, i, j);
        weigh(now);
        for (int i = 0; i < m; ++i) collapse(i);
        for (int i = 0; i < m; ++i) {
            const Mode<T> &mode = c.modes[i];
            for (int k = mode.place; k < mode.place + mode.size(); ++k)
                arena[k] = select<T>(after.linked, arena[k], now.arena[k]);
            probability[i] = select<T>(after.linked, probability[i], now.probability[i]);
        }
    }

  private:
    struct Pair {
        T x[largest_state], P[packed_size(largest_state)], weight;
    };
    const Composition<T> &c;
    Step<T> forward;
    std::vector<Pair> back;
    std::vector<T> next_arena, next_probability, log_weight;

    void pair(const Record<T> &now, const Record<T> &after, int i, int j) {
        const Mode<T> &from = c.modes[i], &to = c.modes[j];
        const int ni = from.shape.n, nj = to.shape.n, size = packed_size(nj);
        const int *places = &to.sources[i * (nj + size)];
        constexpr int L = largest_state;
        T start[L + packed_size(L)], x[L], F[L * L], Q[packed_size(L)], FP[L * L], ahead[packed_size(L)];
        int at[L];  // mode j's components in mode i, or -1
        for (int k = 0; k < nj; ++k) at[k] = place_of(to.shape, k, from.shape);
        for (int k = 0; k < nj + size; ++k) start[k] = now.arena[places[k]];
        to.kernels.linearise(start, forward.coefficient(j), after.has_input ? after.input : nullptr, x, F, Q);
        for (int r = 0; r < nj; ++r)
            for (int k = 0; k < nj; ++k) {
                T sum = splat<T>(0.0);
                for (int l = 0; l < nj; ++l) sum = sum + F[r * nj + l] * start[nj + packed(l, k)];
                FP[r * nj + k] = sum;
            }
        for (int r = 0; r < nj; ++r)
            for (int k = 0; k <= r; ++k) {
                T sum = Q[packed(r, k)];
                for (int l = 0; l < nj; ++l) sum = sum + FP[r * nj + l] * F[k * nj + l];
                ahead[packed(r, k)] = r == k ? sum * (1.0 + rounding_share(nj)) : sum;
            }
        T chol[packed_size(L)], y[L], gain[L * L];
        cholesky<T>(nj, ahead, chol);
        for (int k = 0; k < nj; ++k) y[k] = next_arena[to.place + k] - x[k];
        for (int r = 0; r < ni; ++r) {  // gain C = cov(x_i, x_j-) (P-)^-1, row by row
            T *row = gain + r * nj;
            for (int k = 0; k < nj; ++k) {
                row[k] = splat<T>(0.0);
                for (int l = 0; l < nj; ++l)
                    if (at[l] >= 0) row[k] = row[k] + now.arena[from.place + ni + packed(r, at[l])] * F[k * nj + l];
            }
            solve_lower<T>(nj, chol, row);
            solve_upper<T>(nj, chol, row);
        }
        Pair &p = back[i * c.count + j];
        for (int r = 0; r < ni; ++r) {
            p.x[r] = now.arena[from.place + r];
            for (int k = 0; k < nj; ++k) p.x[r] = p.x[r] + gain[r * nj + k] * y[k];
        }
        covariance(now, from, to, at, F, Q, start, gain, p);
        if (c.count > 1) log_weight[i * c.count + j] = log_density(nj, chol, y);
    }

    // (I - C F) P (I - C F)' + C (Q + F V F' + Ps) C', V the covariance of what mode i does not have: a sum of squares.
    void covariance(const Record<T> &now, const Mode<T> &from, const Mode<T> &to, const int *at, const T *F, const T *Q, const T *start,
                    const T *gain, Pair &p) const {
        const int ni = from.shape.n, nj = to.shape.n;
        constexpr int L = largest_state;
        T G[L * L], CF[L * L], noise[packed_size(L)];
        for (int r = 0; r < ni; ++r)
            for (int l = 0; l < nj; ++l) {
                T sum = splat<T>(0.0);
                for (int k = 0; k < nj; ++k) sum = sum + gain[r * nj + k] * F[k * nj + l];
                CF[r * nj + l] = sum;
            }
        for (int r = 0; r < ni; ++r) {
            for (int q = 0; q < ni; ++q) G[r * ni + q] = splat<T>(r == q ? 1.0 : 0.0);
            for (int l = 0; l < nj; ++l)
                if (at[l] >= 0) G[r * ni + at[l]] = G[r * ni + at[l]] - CF[r * nj + l];
        }
        for (int k = 0; k < packed_size(nj); ++k) noise[k] = Q[k] + next_arena[to.place + nj + k];
        const auto part = [&](const T *A, int stride, int n, auto &&element, int r, int q, T sum) {
            for (int k = 0; k < n; ++k) {
                T inner = splat<T>(0.0);
                for (int l = 0; l < n; ++l) inner = inner + element(k, l) * A[q * stride + l];
                sum = sum + A[r * stride + k] * inner;
            }
            return sum;
        };
        const auto own = [&](int k, int l) { return now.arena[from.place + ni + packed(k, l)]; };
        const auto grown = [&](int k, int l) { return noise[packed(k, l)]; };
        const auto entered = [&](int k, int l) { return at[k] < 0 && at[l] < 0 ? start[nj + packed(k, l)] : splat<T>(0.0); };
        const bool enters = std::any_of(at, at + nj, [](int place) { return place < 0; });
        for (int r = 0; r < ni; ++r)
            for (int q = 0; q <= r; ++q) {
                T sum = part(G, ni, ni, own, r, q, splat<T>(0.0));
                sum = part(gain, nj, nj, grown, r, q, sum);
                if (enters) sum = part(CF, nj, nj, entered, r, q, sum);
                p.P[packed(r, q)] = r == q ? sum * (1.0 + rounding_share(ni)) : sum;
            }
    }

    T log_density(int n, const T *chol, const T *y) const {
        T white[largest_state], square = splat<T>(0.0), det = splat<T>(1.0);
        for (int k = 0; k < n; ++k) white[k] = y[k], det = det * chol[packed(k, k)];
        solve_lower<T>(n, chol, white);
        for (int k = 0; k < n; ++k) square = square + white[k] * white[k];
        return -0.5 * square - logarithm<T>(det);
    }

    void weigh(const Record<T> &now) {
        const int m = c.count;
        const T least = splat<T>(1e-100);
        for (int j = 0; j < m; ++j) {
            if (m == 1) {
                back[0].weight = splat<T>(1.0);
                continue;
            }
            T most = splat<T>(-std::numeric_limits<double>::infinity()), sum = splat<T>(0.0);
            for (int i = 0; i < m; ++i) {
                const T link = larger<T>(forward.transition()[i * m + j] * now.probability[i], least);
                log_weight[i * m + j] = log_weight[i * m + j] + logarithm<T>(link);
                most = larger<T>(most, log_weight[i * m + j]);
            }
            for (int i = 0; i < m; ++i) {
                T &w = back[i * m + j].weight;
                w = exponential<T>(log_weight[i * m + j] - most), sum = sum + w;
            }
            for (int i = 0; i < m; ++i) back[i * m + j].weight = back[i * m + j].weight / sum * next_probability[j];
        }
    }

    void collapse(int i) {
        const Mode<T> &mode = c.modes[i];
        const int n = mode.shape.n, m = c.count;
        T total = splat<T>(0.0), share[64];
        for (int j = 0; j < m; ++j) total = total + larger<T>(back[i * m + j].weight, splat<T>(1e-100));
        for (int j = 0; j < m; ++j) share[j] = larger<T>(back[i * m + j].weight, splat<T>(1e-100)) / total;
        T *x = &arena[mode.place], *P = x + n;
        for (int r = 0; r < n; ++r) {
            x[r] = splat<T>(0.0);
            for (int j = 0; j < m; ++j) x[r] = x[r] + share[j] * back[i * m + j].x[r];
        }
        for (int r = 0; r < n; ++r)
            for (int q = 0; q <= r; ++q) {
                T sum = splat<T>(0.0);
                for (int j = 0; j < m; ++j) {
                    const Pair &p = back[i * m + j];
                    sum = sum + share[j] * (p.P[packed(r, q)] + (p.x[r] - x[r]) * (p.x[q] - x[q]));
                }
                P[packed(r, q)] = sum;
            }
        probability[i] = total;
    }
};

}  // namespace jink::inline JINK_LEVEL
