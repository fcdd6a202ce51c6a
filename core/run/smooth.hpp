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
//
// What depends on mode j alone (its message's root, its noise) is computed once, not for each pair; F too where it does not depend
// on the state. Then a pair costs one fusion. The arithmetic is in smooth_kernels.hpp.
#pragma once

#include "run/smooth_kernels.hpp"
#include "run/smooth_one.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class Smooth {
  public:
    explicit Smooth(const Composition<T> &composition);

    std::vector<T> arena, probability;  // the smoothed modes of the current scan

    void last(const Record<T> &record);

    // From the scan after, back to this one.
    void step(const Record<T> &now, const Record<T> &after);

  private:
    static constexpr int L = largest_state, most_entering = 4;
    static constexpr double log_least = -690.77552789821368;  // of 1e-300
    struct Message {
        T J[packed_size(L)], h[L], s;
        void clear() { *this = Message{}; }
        void keep(int n, Mask<T> lanes_with_it) {
            const T zero = splat<T>(0.0);
            for (int k = 0; k < packed_size(n); ++k) J[k] = select<T>(lanes_with_it, J[k], zero);
            for (int k = 0; k < n; ++k) h[k] = select<T>(lanes_with_it, h[k], zero);
            s = select<T>(lanes_with_it, s, zero);
        }
    };
    // A message as s - 1/2 |g - R' e|^2.
    struct Root {
        T R[packed_size(L)], g[L], s;
    };
    // Mode j's message through the motion to it: what is the same for all modes before of the same components.
    struct Passage {
        T B[L * L], J[packed_size(L)], v[most_entering * L], scale[most_entering], s;
        Root own;  // of a regressed mode: blurred by the noise of this pair
        const Root *root;
    };
    struct Pair {
        T own[packed_size(L)], h[L], x[L], P[packed_size(L)], log_weight, share;
        const T *J;  // its own, or its passage's
    };
    // Of a pair of modes: mode j's components in mode i (or -1), those that enter, and where it passes.
    struct Route {
        int at[L], entering[most_entering], count = 0, passage = 0;
        bool first = true, alike = true;  // the first pair of its passage; both modes have the same components
    };
    const Composition<T> &c;
    Propagate<T> forward;
    SmoothOne<T> one;
    std::vector<SmoothKernels<T>> kernels;
    std::vector<Message> messages, next;
    std::vector<Root> roots;
    std::vector<Route> routes;  // of modes i and j at i * count + j, as the pairs
    std::vector<Passage> passages;
    std::vector<Pair> pairs;
    std::vector<T> log_total;                // of each mode: its pairs' weights together
    std::vector<T> log_transition, log_now;  // of Pi and of the filtered probabilities
    std::vector<T> factors;                  // Cholesky factors of the filtered covariances
    T seen_dt;

    const T *coefficient(const Record<T> &after, int j) const {
        return after.coefficients.empty() ? forward.coefficient(j) : &after.coefficients[j * largest_coefficients];
    }

    // What the scan after measured, as seen by mode j; its message becomes empty where the track begins with that scan.
    void add_measurements(const Record<T> &after, int j) {
        Message &m = next[j];
        add_measurement(after, j, c.sensors[after.sensor], after.measurement, m);
        for (int k = 0; k < int(after.others.size()); ++k) add_measurement(after, j, c.sensors[k + 1], after.others[k], m);
        if (!all(after.linked)) m.keep(c.modes[j].shape.n, after.linked);
        Root &root = roots[j];
        kernels[j].root(m.J, m.h, root.R, root.g);
        root.s = m.s + 0.5 * square(c.modes[j].shape.n, root.g);
        if (c.modes[j].kernels.regressed) return;
        T Q[packed_size(L)] = {};
        c.modes[j].kernels.add_noise(coefficient(after, j), Q);
        root.s = root.s - 0.5 * kernels[j].blur(Q, root.R, root.g);
    }

    static T square(int n, const T *g) {
        T sum = g[0] * g[0];
        for (int k = 1; k < n; ++k) sum = sum + g[k] * g[k];
        return sum;
    }

    void add_measurement(const Record<T> &after, int j, const Sensor<T> &sensor, const Measurement<T> &z, Message &m) const {
        const SensorSpec spec = seen(sensor);
        if (spec.linear() && !z.full) return add_components(after, j, spec, z, m);
        constexpr int M = largest_measurement;
        const Mode<T> &mode = c.modes[j];
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

    // Components of the state themselves, each with noise of its own.
    void add_components(const Record<T> &after, int j, const SensorSpec &spec, const Measurement<T> &z, Message &m) const {
        const Mode<T> &mode = c.modes[j];
        const T zero = splat<T>(0.0);
        for (int r = 0; r < spec.rows; ++r) {
            const int p = (r % spec.axes) * mode.shape.block + r / spec.axes;
            const T weight = select<T>(z.present[r], 1.0 / z.R[r], zero);
            const T y = select<T>(z.present[r], z.z[r] - after.arena[mode.place + p], zero), h = weight * y;
            m.J[packed(p, p)] = m.J[packed(p, p)] + weight;
            m.h[p] = m.h[p] + h;
            m.s = m.s - 0.5 * h * y;
        }
    }

    // Mode j's message through the motion from mode i, whose state as mode j sees it is `start`.
    void open(Passage &to, const Route &route, const Record<T> &after, int j, const T *start, T *ahead) {
        const Mode<T> &mode = c.modes[j];
        const SmoothKernels<T> &kernel = kernels[j];
        const int n = mode.shape.n;
        to.root = &roots[j];
        if (mode.kernels.regressed) {
            T F[L * L], Q[packed_size(L)];
            mode.kernels.linearise(start, coefficient(after, j), after.input_of(j), ahead, F, Q);
            to.own = roots[j], to.root = &to.own;
            to.own.s = to.own.s - 0.5 * kernel.blur(Q, to.own.R, to.own.g);
            kernel.pull(to.own.R, F, to.B);
        } else {
            mode.kernels.pull(start, coefficient(after, j), to.root->R, to.B);
        }
        to.s = to.root->s;
        if (route.count) enter(to, route, kernel, n, start + n);
        kernel.gram(to.B, to.J);
    }

    // What mode i does not have enters with its prior covariance: noise V V' of the start, in B along B V.
    void enter(Passage &to, const Route &route, const SmoothKernels<T> &kernel, int n, const T *P) {
        T V[packed_size(most_entering)], root[packed_size(most_entering)];
        for (int r = 0; r < route.count; ++r)
            for (int k = 0; k <= r; ++k) V[packed(r, k)] = P[packed(route.entering[r], route.entering[k])];
        cholesky<T>(route.count, V, root);
        for (int k = 0; k < route.count; ++k) {
            T *v = &to.v[k * L];
            for (int r = 0; r < n; ++r) {
                v[r] = splat<T>(0.0);
                for (int l = k; l < route.count; ++l) v[r] = v[r] + to.B[r * n + route.entering[l]] * root[packed(l, k)];
            }
            to.s = to.s - 0.5 * kernel.enter(v, to.B, to.scale[k]);
        }
    }

    // Mode j's message as mode i hears it.
    void hear(const Record<T> &now, const Record<T> &after, int i, int j) {
        const Mode<T> &from = c.modes[i], &mode = c.modes[j];
        const Route &route = routes[i * c.count + j];
        Passage &passage = passages[route.passage];
        const int n = mode.shape.n, size = packed_size(n);
        const int *places = &mode.sources[i * (n + size)];
        T start[L + packed_size(L)], ahead[L], d[L], told[L], heard[L];
        const int wanted = route.first ? n + size : n;  // with the covariance or without
        for (int k = 0; k < wanted; ++k) start[k] = now.arena[places[k]];
        if (!mode.kernels.regressed) mode.kernels.advance(start, coefficient(after, j), after.input_of(j), ahead);
        if (route.first) open(passage, route, after, j, start, ahead);
        for (int k = 0; k < n; ++k) d[k] = ahead[k] - after.arena[mode.place + k];
        kernels[j].move(passage.root->R, passage.root->g, d, told);
        for (int e = 0; e < route.count; ++e) {
            const T *v = &passage.v[e * L];
            T along = v[0] * told[0];
            for (int r = 1; r < n; ++r) along = along + v[r] * told[r];
            along = along * passage.scale[e];
            for (int r = 0; r < n; ++r) told[r] = told[r] - v[r] * along;
        }
        Pair &p = pairs[i * c.count + j];
        p.log_weight = passage.s - 0.5 * kernels[j].hear(passage.B, told, route.alike ? p.h : heard);
        p.J = passage.J;
        if (route.alike) return;
        p.J = p.own;  // the components that both have; zero elsewhere
        for (int k = 0; k < packed_size(from.shape.n); ++k) p.own[k] = splat<T>(0.0);
        for (int k = 0; k < from.shape.n; ++k) p.h[k] = splat<T>(0.0);
        for (int k = 0; k < n; ++k) {
            if (route.at[k] < 0) continue;
            p.h[route.at[k]] = heard[k];
            for (int l = 0; l <= k; ++l)
                if (route.at[l] >= 0) p.own[packed(route.at[k], route.at[l])] = passage.J[packed(k, l)];
        }
    }

    void fuse(const Record<T> &now, int i, int j) {
        Pair &p = pairs[i * c.count + j];
        const Mode<T> &mode = c.modes[i];
        T gain;
        const T log_det = kernels[i].fuse(&factors[i * packed_size(L)], p.J, p.h, p.x, p.P, gain);
        for (int k = 0; k < mode.shape.n; ++k) p.x[k] = now.arena[mode.place + k] + p.x[k];
        const T link = larger<T>(log_transition[i * c.count + j] + log_now[i], splat<T>(log_least));
        p.log_weight = link + p.log_weight + 0.5 * (gain - log_det);
    }

    // A track whose next scan has nothing to do with this one ends here: its estimate is the filtered one, to the bit.
    void end_where_unlinked(const Record<T> &now, Mask<T> linked, int i) {
        const Mode<T> &mode = c.modes[i];
        for (int k = mode.place; k < mode.place + mode.size(); ++k) arena[k] = select<T>(linked, arena[k], now.arena[k]);
        probability[i] = select<T>(linked, probability[i], now.probability[i]);
        messages[i].keep(mode.shape.n, linked);
    }

    // Where every number of every mode is. A message beyond the range of numbers is dropped: the filtered estimate stays.
    Mask<T> finite() const {
        T sum[4] = {};
        const auto look = [&](int n, const T *from) {
            for (int k = 0; k < n; ++k) sum[k % 4] = sum[k % 4] + (from[k] - from[k]);
        };
        for (int i = 0; i < c.count; ++i) {
            const Mode<T> &mode = c.modes[i];
            const Message &m = messages[i];
            look(mode.size(), &arena[mode.place]);
            look(1, &probability[i]);
            look(mode.shape.n, m.h);
            look(packed_size(mode.shape.n), m.J);
            look(1, &m.s);
        }
        return inverse(is_nan((sum[0] + sum[1]) + (sum[2] + sum[3])));
    }

    // Each pair's share of its first mode's weight; returns the logarithm of that.
    T share_out(int i) {
        Pair *p = &pairs[i * c.count];
        T most = p[0].log_weight, sum = splat<T>(0.0);
        for (int j = 1; j < c.count; ++j) most = larger<T>(most, p[j].log_weight);
        for (int j = 0; j < c.count; ++j) p[j].share = exponential<T>(p[j].log_weight - most), sum = sum + p[j].share;
        const T over = 1.0 / sum;
        for (int j = 0; j < c.count; ++j) p[j].share = p[j].share * over;
        return most + logarithm<T>(sum);
    }

    // Mode i's smoothed estimate over its pairs, matched in two moments, and its message.
    //
    // Where the pairs disagree the averaged message would be too sure of itself: its covariance grows by their spread about the
    // smoothed mean, its peak stays.
    void collapse(int i) {
        const Mode<T> &mode = c.modes[i];
        const int n = mode.shape.n, size = packed_size(n), m = c.count;
        const Pair *p = &pairs[i * m];
        T *x = &arena[mode.place], *P = x + n;
        Message &out = messages[i];
        for (int r = 0; r < n; ++r) x[r] = p[0].share * p[0].x[r], out.h[r] = p[0].share * p[0].h[r];
        for (int k = 0; k < size; ++k) P[k] = p[0].share * p[0].P[k], out.J[k] = p[0].share * p[0].J[k];
        for (int j = 1; j < m; ++j) {
            const T share = p[j].share;
            for (int r = 0; r < n; ++r) x[r] = x[r] + share * p[j].x[r], out.h[r] = out.h[r] + share * p[j].h[r];
            for (int k = 0; k < size; ++k) P[k] = P[k] + share * p[j].P[k], out.J[k] = out.J[k] + share * p[j].J[k];
        }
        for (int j = 0; j < m; ++j) {
            T *d = &spread[j * n];
            const T root = square_root(p[j].share);
            for (int r = 0; r < n; ++r) d[r] = root * (p[j].x[r] - x[r]);
            for (int r = 0; r < n; ++r)
                for (int q = 0; q <= r; ++q) P[packed(r, q)] = P[packed(r, q)] + d[r] * d[q];
        }
        for (int r = 0; r < n; ++r) P[packed(r, r)] = P[packed(r, r)] * (1.0 + rounding_share(n));
        T R[packed_size(L)], g[L], gain;
        kernels[i].root(out.J, out.h, R, g);
        kernels[i].blur_by_columns(spread.data(), m, R, g);
        kernels[i].square(R, g, out.J, out.h);
        // its level such that under the filtered estimate it weighs what its pairs weigh together
        const T log_det = kernels[i].level(&factors[i * packed_size(L)], out.J, out.h, gain);
        out.s = log_total[i] - log_now[i] - 0.5 * (gain - log_det);
    }

    std::vector<T> spread;  // columns: the pairs of a mode about its mean, by the roots of their shares

    void lay_out_routes();
};

template <class T>
Smooth<T>::Smooth(const Composition<T> &composition)
    : c(composition), forward(c), one(c), messages(c.count), next(c.count), roots(c.count), routes(c.count * c.count), pairs(c.count * c.count),
      log_total(c.count), log_transition(c.count * c.count), log_now(c.count), factors(c.count * packed_size(L)), seen_dt(nan_of<T>()),
      spread(c.count * L) {
    for (int i = 0; i < c.count; ++i) kernels.push_back(smooth_kernels<T>(c.modes[i].shape, c.modes[i].kernels.regressed));
    lay_out_routes();
}

// Pairs to a mode share a passage if its motion is linear and the same components enter, with the same prior.
template <class T> void Smooth<T>::lay_out_routes() {
    int passages_yet = 0;
    for (int j = 0; j < c.count; ++j)
        for (int i = 0; i < c.count; ++i) {
            const Mode<T> &from = c.modes[i], &to = c.modes[j];
            Route &route = routes[i * c.count + j];
            for (int k = 0; k < to.shape.n; ++k) {
                route.at[k] = place_of(to.shape, k, from.shape);
                if (route.at[k] < 0) route.entering[route.count++] = k;
            }
            route.alike = route.count == 0 && from.shape.n == to.shape.n;
            for (int before = 0; before < i && route.first && to.kernels.linear; ++before) {
                const Route &other = routes[before * c.count + j];
                if (!std::equal(route.entering, route.entering + route.count, other.entering, other.entering + other.count)) continue;
                route.first = false, route.passage = other.passage;
            }
            if (route.first) route.passage = passages_yet++;
        }
    passages.resize(passages_yet);
}

template <class T> void Smooth<T>::last(const Record<T> &record) {
    arena = record.arena, probability = record.probability;
    for (auto &m : messages) m.clear();
}

template <class T> void Smooth<T>::step(const Record<T> &now, const Record<T> &after) {
    const int m = c.count;
    if (m == 1) {
        one.step(now, after, &arena[c.modes[0].place]);
        return;
    }
    next.swap(messages);
    const T dt = select<T>(after.linked, after.dt, splat<T>(0.0)), least = splat<T>(1e-300);
    forward.elapse(dt);
    if (!all(dt == seen_dt))
        for (int k = 0; k < m * m; ++k) log_transition[k] = logarithm<T>(larger<T>(forward.transition()[k], least));
    seen_dt = dt;
    for (int j = 0; j < m; ++j) add_measurements(after, j);
    for (int j = 0; j < m; ++j)
        for (int i = 0; i < m; ++i) hear(now, after, i, j);
    T most = splat<T>(-std::numeric_limits<double>::infinity()), sum = splat<T>(0.0);
    for (int i = 0; i < m; ++i) {
        const Mode<T> &mode = c.modes[i];
        log_now[i] = logarithm<T>(larger<T>(now.probability[i], least));
        kernels[i].factor(&now.arena[mode.place + mode.shape.n], &factors[i * packed_size(L)]);
        for (int j = 0; j < m; ++j) fuse(now, i, j);
        log_total[i] = share_out(i), most = larger<T>(most, log_total[i]);
        collapse(i);
    }
    for (int i = 0; i < m; ++i) probability[i] = exponential<T>(log_total[i] - most), sum = sum + probability[i];
    const T over = 1.0 / sum, level = most + logarithm<T>(sum);
    for (int i = 0; i < m; ++i) {
        probability[i] = probability[i] * over;
        messages[i].s = messages[i].s - level;
        if (!all(after.linked)) end_where_unlinked(now, after.linked, i);
    }
    const Mask<T> sound = finite();
    for (int i = 0; !all(sound) && i < m; ++i) end_where_unlinked(now, sound, i);
}

}  // namespace jink::inline JINK_LEVEL
