// Fixed-interval smoothing of several modes, by messages from the future.
//
// Of each mode j the measurements after a scan say, as a function of the state x about the filtered estimate x_j,
//
//   log p(Z_future | x, j) = s_j + h_j' (x - x_j) - 1/2 (x - x_j)' J_j (x - x_j)
//
// with J = 0 at the end of a track. A message goes back over a scan in four steps: the scan's own measurement is added; for each
// mode i before, the process noise (and the prior of what mode i does not have) is integrated out and F_j' J F_j formed; each pair
// (i, j) is weighed and fused with mode i's filtered estimate, which gives the smoothed estimates and probabilities; and the
// pairs of a mode i become its message, averaged in logarithms by their weights. Unlike the backward recursion on estimates
// (Rauch-Tung-Striebel for each pair), whose gains have no feedback from the measurements, approximation errors die out.
// Equal to Rauch-Tung-Striebel when the modes are the same.
//
// Two-filter smoothing: Fraser & Potter, IEEE Trans. AC-14(4), 1969; for switching systems: Helmick, Blair & Hoffman, IEEE Trans.
// IT-41(6), 1995. The averaging of messages is ours (docs/smoothing.md).
#pragma once

#include "run/smooth_one.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class Smooth {
  public:
    explicit Smooth(const Composition<T> &composition);

    std::vector<T> arena, probability;  // the smoothed modes of the current scan

    void last(const Record<T> &record);

    // The same in some lanes, while the others go on.
    void last(const Record<T> &record, Mask<T> lanes_of_it);

    // From the scan after, back to this one.
    void step(const Record<T> &now, const Record<T> &after);

  private:
    static constexpr int L = largest_state;
    struct Message {
        T J[packed_size(L)], h[L], s;
        void clear() {
            for (auto &v : J) v = splat<T>(0.0);
            for (auto &v : h) v = splat<T>(0.0);
            s = splat<T>(0.0);
        }
        void keep(Mask<T> lanes_with_it) {
            const T zero = splat<T>(0.0);
            for (auto &v : J) v = select<T>(lanes_with_it, v, zero);
            for (auto &v : h) v = select<T>(lanes_with_it, v, zero);
            s = select<T>(lanes_with_it, s, zero);
        }
    };
    struct Pair {
        Message message;
        T x[L], P[packed_size(L)], log_weight, share;
    };
    const Composition<T> &c;
    Propagate<T> forward;
    SmoothOne<T> one;
    std::vector<Message> messages, next;
    std::vector<Pair> pairs;
    std::vector<T> log_total;  // of each mode: its pairs' weights together
    std::vector<T> roots, message_roots;  // Cholesky factors of the filtered covariances, and of the messages' J

    void factor(const Record<T> &now, int i) {
        roots.resize(c.count * packed_size(L));
        const Mode<T> &mode = c.modes[i];
        cholesky<T>(mode.shape.n, &now.arena[mode.place + mode.shape.n], &roots[i * packed_size(L)]);
    }

    // What the scan after measured, as seen by mode j; its message becomes empty where the track begins with that scan.
    void add_measurements(const Record<T> &after, int j) {
        Message &m = next[j];
        add_measurement(after, j, c.sensors[after.sensor], after.measurement, m);
        for (int k = 0; k < int(after.others.size()); ++k) add_measurement(after, j, c.sensors[k + 1], after.others[k], m);
        m.keep(after.linked);
        message_roots.resize(c.count * packed_size(L));
        semidefinite_cholesky<T>(c.modes[j].shape.n, m.J, &message_roots[j * packed_size(L)]);
    }

    void add_measurement(const Record<T> &after, int j, const Sensor<T> &sensor, const Measurement<T> &z, Message &m) const {
        constexpr int M = largest_measurement;
        const Mode<T> &mode = c.modes[j];
        const SensorSpec spec = seen(sensor);
        const int n = mode.shape.n;
        const T *x = &after.arena[mode.place], zero = splat<T>(0.0), one_ = splat<T>(1.0);
        T y[M], H[M * L], R[packed_size(M)], chol[packed_size(M)], column[M];
        observe(spec, mode.shape.block, n, x, y);
        residual(spec, z.z, y, y);
        observe_jacobian(spec, mode.shape.block, n, x, H);
        for (int r = 0; r < spec.rows; ++r) {
            y[r] = select<T>(z.present[r], y[r], zero);
            for (int k = 0; k < n; ++k) H[r * n + k] = select<T>(z.present[r], H[r * n + k], zero);
            for (int q = 0; q <= r; ++q) {
                const T noise = z.full ? z.R[packed(r, q)] : q == r ? z.R[r] : zero;
                R[packed(r, q)] = select<T>(z.present[r] & z.present[q], noise, q == r ? one_ : zero);
            }
        }
        cholesky<T>(spec.rows, R, chol);
        solve_lower<T>(spec.rows, chol, y);
        for (int k = 0; k < n; ++k) {
            for (int r = 0; r < spec.rows; ++r) column[r] = H[r * n + k];
            solve_lower<T>(spec.rows, chol, column);
            for (int r = 0; r < spec.rows; ++r) H[r * n + k] = column[r];
        }
        for (int r = 0; r < spec.rows; ++r) {
            m.s = m.s - 0.5 * y[r] * y[r];
            for (int k = 0; k < n; ++k) {
                m.h[k] = m.h[k] + H[r * n + k] * y[r];
                for (int l = 0; l <= k; ++l) m.J[packed(k, l)] = m.J[packed(k, l)] + H[r * n + k] * H[r * n + l];
            }
        }
    }

    void pair(const Record<T> &now, const Record<T> &after, int i, int j) {
        const Mode<T> &from = c.modes[i], &to = c.modes[j];
        const int ni = from.shape.n, nj = to.shape.n, size = packed_size(nj);
        const int *places = &to.sources[i * (nj + size)];
        T start[L + packed_size(L)], ahead[L], F[L * L], Q[packed_size(L)];
        int at[L];  // mode j's components in mode i, or -1
        for (int k = 0; k < nj; ++k) at[k] = place_of(to.shape, k, from.shape);
        for (int k = 0; k < nj + size; ++k) start[k] = now.arena[places[k]];
        to.kernels.linearise(start, after.coefficients.empty() ? forward.coefficient(j) : &after.coefficients[j * largest_coefficients],
                             after.input_of(j), ahead, F, Q);
        if (forward.coast.active()) forward.coast(to, select<T>(after.linked, after.dt, splat<T>(0.0)), after.coasted, start, ahead);
        enter(nj, at, start + nj, F, Q);
        Message about = next[j];  // moved from mode j's filtered estimate to the prediction from mode i
        T d[L], Jd[L];
        for (int k = 0; k < nj; ++k) d[k] = ahead[k] - after.arena[to.place + k];
        times(nj, about.J, d, Jd);
        for (int k = 0; k < nj; ++k) {
            about.s = about.s + (about.h[k] - 0.5 * Jd[k]) * d[k];
            about.h[k] = about.h[k] - Jd[k];
        }
        integrate(nj, Q, &message_roots[j * packed_size(L)], about);
        Pair &p = pairs[i * c.count + j];
        p.message.clear();
        p.message.s = about.s;
        T A[L * L];  // F' restricted to what mode i has, ni by nj
        for (int k = 0; k < ni * nj; ++k) A[k] = splat<T>(0.0);
        for (int l = 0; l < nj; ++l)
            for (int k = 0; k < nj && at[l] >= 0; ++k) A[at[l] * nj + k] = F[k * nj + l];
        for (int r = 0; r < ni; ++r)
            for (int k = 0; k < nj; ++k) p.message.h[r] = p.message.h[r] + A[r * nj + k] * about.h[k];
        add_congruence(ni, nj, A, about.J, p.message.J);
        T moved[L];
        const T log_det = parallel_sum<T>(ni, &roots[i * packed_size(L)], p.message.J, p.P);
        times(ni, p.P, p.message.h, moved);
        T gain = splat<T>(0.0);
        for (int k = 0; k < ni; ++k) p.x[k] = now.arena[from.place + k] + moved[k], gain = gain + p.message.h[k] * moved[k];
        const T link = larger<T>(forward.transition()[i * c.count + j] * now.probability[i], splat<T>(1e-300));
        p.log_weight = logarithm<T>(link) + p.message.s + 0.5 * (gain - log_det);
    }

    // A track whose next scan has nothing to do with this one ends here: its estimate is the filtered one, to the bit.
    void end_where_unlinked(const Record<T> &now, Mask<T> linked, int i) {
        const Mode<T> &mode = c.modes[i];
        for (int k = mode.place; k < mode.place + mode.size(); ++k) arena[k] = select<T>(linked, arena[k], now.arena[k]);
        probability[i] = select<T>(linked, probability[i], now.probability[i]);
        messages[i].keep(linked);
    }

    // Where every number of every mode is. A message beyond the range of numbers is dropped: the filtered estimate stays.
    Mask<T> finite() const {
        T sum = splat<T>(0.0);
        for (const T &value : arena) sum = sum + (value - value);
        for (const T &value : probability) sum = sum + (value - value);
        for (int i = 0; i < c.count; ++i) {
            const int n = c.modes[i].shape.n;
            const Message &m = messages[i];
            for (int k = 0; k < n; ++k) sum = sum + (m.h[k] - m.h[k]);
            for (int k = 0; k < packed_size(n); ++k) sum = sum + (m.J[k] - m.J[k]);
            sum = sum + (m.s - m.s);
        }
        return inverse(is_nan(sum));
    }

    // Q += F V F', V the covariance of what the mode before does not have.
    static void enter(int n, const int *at, const T *P, const T *F, T *Q) {
        T V[packed_size(L)];
        bool any_enters = false;
        for (int r = 0; r < n; ++r)
            for (int k = 0; k <= r; ++k) {
                const bool enters = at[r] < 0 && at[k] < 0;
                V[packed(r, k)] = enters ? P[packed(r, k)] : splat<T>(0.0);
                any_enters = any_enters || enters;
            }
        if (any_enters) add_congruence(n, n, F, V, Q);
    }

    // The message before noise of covariance Q, with J = R R', h = R g and C C' = I + R' Q R:
    //   J <- R (C C')^-1 R' ,  h <- R (C C')^-1 g ,  s <- s + 1/2 (g' g - g' (C C')^-1 g - log det C C')
    // Nothing large is subtracted, however large the noise.
    static void integrate(int n, const T *Q, const T *R, Message &m) {
        T W[L * L], C[packed_size(L)], g[L], before = splat<T>(0.0), after = before;
        const T log_det = parallel_sum<T>(n, R, Q, m.J, W, C);
        for (int k = 0; k < n; ++k) {  // R g = h; h has nothing where R has a column of zeros
            T sum = m.h[k];
            for (int l = 0; l < k; ++l) sum = sum - R[packed(k, l)] * g[l];
            const T pivot = R[packed(k, k)];
            const Mask<T> real = pivot > splat<T>(0.0);
            g[k] = select<T>(real, sum / select<T>(real, pivot, splat<T>(1.0)), splat<T>(0.0));
            before = before + g[k] * g[k];
        }
        solve_lower<T>(n, C, g);
        for (int k = 0; k < n; ++k) m.h[k] = splat<T>(0.0), after = after + g[k] * g[k];
        for (int l = 0; l < n; ++l)
            for (int k = 0; k < n; ++k) m.h[k] = m.h[k] + W[l * n + k] * g[l];
        m.s = m.s + 0.5 * (before - after - log_det);
    }

    static void times(int n, const T *P, const T *x, T *out) {
        for (int r = 0; r < n; ++r) {
            out[r] = P[packed(r, 0)] * x[0];
            for (int k = 1; k < n; ++k) out[r] = out[r] + P[packed(r, k)] * x[k];
        }
    }

    // Each pair's share of its first mode's weight; returns the logarithm of that.
    T share_out(int i) {
        Pair *p = &pairs[i * c.count];
        T most = p[0].log_weight, sum = splat<T>(0.0);
        for (int j = 1; j < c.count; ++j) most = larger<T>(most, p[j].log_weight);
        for (int j = 0; j < c.count; ++j) p[j].share = exponential<T>(p[j].log_weight - most), sum = sum + p[j].share;
        for (int j = 0; j < c.count; ++j) p[j].share = p[j].share / sum;
        return most + logarithm<T>(sum);
    }

    // Mode i's smoothed estimate over its pairs, matched in two moments, and its message.
    //
    // Where the pairs disagree the averaged message would be too sure of itself: its covariance grows by their spread about the
    // smoothed mean, its peak stays.
    void collapse(const Record<T> &now, int i, T log_weight) {
        const Mode<T> &mode = c.modes[i];
        const int n = mode.shape.n, m = c.count;
        const Pair *p = &pairs[i * m];
        const T zero = splat<T>(0.0);
        T *x = &arena[mode.place], *P = x + n, spread[packed_size(L)];
        Message &out = messages[i];
        out.clear();
        for (int r = 0; r < n; ++r) x[r] = zero;
        for (int k = 0; k < packed_size(n); ++k) P[k] = spread[k] = zero;
        for (int j = 0; j < m; ++j) {
            const T share = p[j].share;
            for (int r = 0; r < n; ++r) x[r] = x[r] + share * p[j].x[r], out.h[r] = out.h[r] + share * p[j].message.h[r];
            for (int k = 0; k < packed_size(n); ++k)
                out.J[k] = out.J[k] + share * p[j].message.J[k], P[k] = P[k] + share * p[j].P[k];
        }
        for (int j = 0; j < m; ++j)
            for (int r = 0; r < n; ++r)
                for (int q = 0; q <= r; ++q)
                    spread[packed(r, q)] = spread[packed(r, q)] + p[j].share * (p[j].x[r] - x[r]) * (p[j].x[q] - x[q]);
        for (int k = 0; k < packed_size(n); ++k) P[k] = P[k] + spread[k];
        for (int r = 0; r < n; ++r) P[packed(r, r)] = P[packed(r, r)] * (1.0 + rounding_share(n));
        T root[packed_size(L)] = {};
        semidefinite_cholesky<T>(n, out.J, root);
        integrate(n, spread, root, out);
        // its level such that under the filtered estimate it weighs what its pairs weigh together
        T fused[packed_size(L)], moved[L], gain = zero;
        const T log_det = parallel_sum<T>(n, &roots[i * packed_size(L)], out.J, fused);
        times(n, fused, out.h, moved);
        for (int k = 0; k < n; ++k) gain = gain + out.h[k] * moved[k];
        const T mine = larger<T>(now.probability[i], splat<T>(1e-300));
        out.s = log_weight - logarithm<T>(mine) - 0.5 * (gain - log_det);
    }
};

template <class T>
Smooth<T>::Smooth(const Composition<T> &composition)
    : c(composition), forward(c), one(c), messages(c.count), next(c.count), pairs(c.count * c.count), log_total(c.count) {}

template <class T> void Smooth<T>::last(const Record<T> &record) {
    arena = record.arena, probability = record.probability;
    for (auto &m : messages) m.clear();
}

template <class T> void Smooth<T>::last(const Record<T> &record, Mask<T> lanes_of_it) {
    for (std::size_t k = 0; k < arena.size(); ++k) arena[k] = select<T>(lanes_of_it, record.arena[k], arena[k]);
    for (std::size_t k = 0; k < probability.size(); ++k) probability[k] = select<T>(lanes_of_it, record.probability[k], probability[k]);
    for (auto &m : messages) m.keep(inverse(lanes_of_it));
}

template <class T> void Smooth<T>::step(const Record<T> &now, const Record<T> &after) {
    if (c.count == 1) {
        one.step(now, after, &arena[c.modes[0].place]);
        return;
    }
    next.swap(messages);
    for (int j = 0; j < c.count; ++j) add_measurements(after, j);
    forward.elapse(select<T>(after.linked, after.dt, splat<T>(0.0)));
    for (int i = 0; i < c.count; ++i) factor(now, i);
    for (int j = 0; j < c.count; ++j)
        for (int i = 0; i < c.count; ++i) pair(now, after, i, j);
    T most = splat<T>(-std::numeric_limits<double>::infinity()), sum = splat<T>(0.0);
    for (int i = 0; i < c.count; ++i) log_total[i] = share_out(i), most = larger<T>(most, log_total[i]);
    for (int i = 0; i < c.count; ++i) probability[i] = exponential<T>(log_total[i] - most), sum = sum + probability[i];
    for (int i = 0; i < c.count; ++i) {
        probability[i] = probability[i] / sum;
        collapse(now, i, log_total[i] - most - logarithm<T>(sum));
        end_where_unlinked(now, after.linked, i);
    }
    const Mask<T> sound = finite();
    for (int i = 0; !all(sound) && i < c.count; ++i) end_where_unlinked(now, sound, i);
}

}  // namespace jink::inline JINK_LEVEL
