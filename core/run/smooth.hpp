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

#include "run/smooth_measurement.hpp"
#include "run/smooth_one.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class Smooth {
  public:
    explicit Smooth(const Composition<T> &composition);

    std::vector<T> arena, probability;  // the smoothed modes of the current scan
    bool covariances = true;            // of several modes, if they are wanted: nothing else needs them

    void last(const Record<T> &record);

    // The same in some lanes, while the others go on.
    void last(const Record<T> &record, Mask<T> lanes_of_it);

    // From the scan after, back to this one.
    void step(const Record<T> &now, const Record<T> &after);

  private:
    static constexpr int L = largest_state;
    static constexpr double log_least = -690.77552789821368;  // of 1e-300
    // Of a pair of modes: mode j's components in mode i (or -1), those that enter, and where it passes.
    struct Route {
        int at[L], entering[most_entering], count = 0, passage = 0;
        bool first = true, alike = true;  // the first pair of its passage; both modes have the same components
    };
    const Composition<T> &c;
    Propagate<T> forward;
    SmoothOne<T> one;
    std::vector<SmoothKernels<T>> kernels;
    std::vector<Message<T>> messages, next;
    std::vector<MessageRoot<T>> roots;
    std::vector<Route> routes;  // of modes i and j at i * count + j, as the pairs
    std::vector<Passage<T>> passages;
    std::vector<SmoothPair<T>> pairs;
    std::vector<T> log_total;                // of each mode: its pairs' weights together
    std::vector<T> log_transition, log_now;  // of Pi and of the filtered probabilities
    std::vector<T> factors;                  // Cholesky factors of the filtered covariances
    std::vector<T> spread;                   // of each mode: its pairs about its mean, column by column
    T seen_dt;

    const T *coefficient(const Record<T> &after, int j) const {
        return after.coefficients.empty() ? forward.coefficient(j) : &after.coefficients[j * largest_coefficients];
    }
    const T *factor(int i) const { return &factors[i * packed_size(L)]; }

    // What the scan after measured, as seen by each mode; messages become empty where the track begins with that scan.
    void add_measurements(const Record<T> &after) {
        for (int j = 0; j < c.count; ++j) {
            const Mode<T> &mode = c.modes[j];
            const T *x = &after.arena[mode.place];
            add_measurement(mode, x, c.sensors[after.sensor], after.measurement, next[j]);
            for (int k = 0; k < int(after.others.size()); ++k) add_measurement(mode, x, c.sensors[k + 1], after.others[k], next[j]);
            if (!all(after.linked)) keep(j, next[j], after.linked);
        }
    }

    // A message in some lanes, none in the others.
    void keep(int j, Message<T> &m, Mask<T> lanes_with_it) const {
        const int n = c.modes[j].shape.n;
        const T zero = splat<T>(0.0);
        for (int k = 0; k < packed_size(n); ++k) m.J[k] = select<T>(lanes_with_it, m.J[k], zero);
        for (int k = 0; k < n; ++k) m.h[k] = select<T>(lanes_with_it, m.h[k], zero);
        m.s = select<T>(lanes_with_it, m.s, zero);
    }

    void blur(const Record<T> &after) {
        for (int j = 0; j < c.count; ++j) kernels[j].root(next[j], roots[j]);
        for (int j = 0; j < c.count; ++j) {
            if (c.modes[j].kernels.regressed) continue;
            T Q[packed_size(L)];
            for (int k = 0; k < packed_size(c.modes[j].shape.n); ++k) Q[k] = splat<T>(0.0);
            c.modes[j].kernels.add_noise(coefficient(after, j), Q);
            kernels[j].blur(Q, roots[j]);
        }
    }

    // Mode j's message through the motion from a state as mode j sees it.
    void open(Passage<T> &to, const Route &route, const Record<T> &after, int j, const T *start) {
        const Mode<T> &mode = c.modes[j];
        const SmoothKernels<T> &kernel = kernels[j];
        const int n = mode.shape.n;
        to.root = &roots[j];
        if (mode.kernels.regressed) {
            T ahead[L], F[L * L], Q[packed_size(L)];
            mode.kernels.linearise(start, coefficient(after, j), after.input_of(j), ahead, F, Q);
            to.own = roots[j], to.root = &to.own;
            kernel.blur(Q, to.own);
            kernel.pull(to.own.R, F, to.B);
        } else {
            mode.kernels.pull(start, coefficient(after, j), to.root->R, to.B);
        }
        to.s = to.root->s;
        if (route.count) enter(to, route, kernel, n, start + n);
        kernel.gram(to.B, to.J);
    }

    // What mode i does not have enters with its prior covariance: noise V V' of the start, in B along B V.
    void enter(Passage<T> &to, const Route &route, const SmoothKernels<T> &kernel, int n, const T *P) {
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
        const Mode<T> &mode = c.modes[j];
        const Route &route = routes[i * c.count + j];
        Passage<T> &passage = passages[route.passage];
        const int n = mode.shape.n, size = packed_size(n);
        T seen[L + packed_size(L)], ahead[L], heard[L];
        const T *start = &now.arena[c.modes[i].place];
        if (!route.alike) {
            const int *places = &mode.sources[i * (n + size)];
            for (int k = 0; k < (route.first ? n + size : n); ++k) seen[k] = now.arena[places[k]];  // with the covariance or without
            start = seen;
        }
        if (route.first) open(passage, route, after, j, start);
        if (mode.kernels.regressed) {
            T F[L * L], Q[packed_size(L)];
            mode.kernels.linearise(start, coefficient(after, j), after.input_of(j), ahead, F, Q);
        } else {
            mode.kernels.advance(start, coefficient(after, j), after.input_of(j), ahead);
        }
        SmoothPair<T> &p = pairs[i * c.count + j];
        p.log_weight = kernels[j].hear(passage, route.count, ahead, &after.arena[mode.place], route.alike ? p.h : heard);
        p.J = passage.J;
        if (!route.alike) take_over(p, route, c.modes[i].shape.n, n, passage.J, heard);
    }

    // The components that both have; zero elsewhere.
    static void take_over(SmoothPair<T> &p, const Route &route, int to, int n, const T *J, const T *h) {
        p.J = p.own;
        for (int k = 0; k < packed_size(to); ++k) p.own[k] = splat<T>(0.0);
        for (int k = 0; k < to; ++k) p.h[k] = splat<T>(0.0);
        for (int k = 0; k < n; ++k) {
            if (route.at[k] < 0) continue;
            p.h[route.at[k]] = h[k];
            for (int l = 0; l <= k; ++l)
                if (route.at[l] >= 0) p.own[packed(route.at[k], route.at[l])] = J[packed(k, l)];
        }
    }

    void fuse(const Record<T> &now) {
        const int m = c.count;
        for (int i = 0; i < m; ++i) {
            const Mode<T> &mode = c.modes[i];
            kernels[i].factor(&now.arena[mode.place + mode.shape.n], &factors[i * packed_size(L)]);
            log_now[i] = logarithm<T>(larger<T>(now.probability[i], splat<T>(1e-300)));
        }
        for (int i = 0; i < m; ++i)
            for (int j = 0; j < m; ++j) {
                SmoothPair<T> &p = pairs[i * m + j];
                const T link = larger<T>(log_transition[i * m + j] + log_now[i], splat<T>(log_least));
                const Scaled<T> mean =
                    kernels[i].fuse(factor(i), p.J, p.h, &now.arena[c.modes[i].place], p.x, covariances ? p.P : nullptr);
                p.log_weight = link + p.log_weight + mean.log, p.share = mean.rest;
            }
    }

    // Each pair's share of its first mode's weight, and each mode's probability.
    void share_out() {
        const int m = c.count;
        T most_of_all = splat<T>(-std::numeric_limits<double>::infinity()), sum_of_all = splat<T>(0.0);
        for (int i = 0; i < m; ++i) {
            SmoothPair<T> *p = &pairs[i * m];
            T most = p[0].log_weight, sum = splat<T>(0.0);
            for (int j = 1; j < m; ++j) most = larger<T>(most, p[j].log_weight);
            for (int j = 0; j < m; ++j) p[j].share = p[j].share * exponential<T>(p[j].log_weight - most), sum = sum + p[j].share;
            const T over = 1.0 / sum;
            for (int j = 0; j < m; ++j) p[j].share = p[j].share * over;
            log_total[i] = most + logarithm<T>(sum), most_of_all = larger<T>(most_of_all, log_total[i]);
        }
        for (int i = 0; i < m; ++i) probability[i] = exponential<T>(log_total[i] - most_of_all), sum_of_all = sum_of_all + probability[i];
        const T over = 1.0 / sum_of_all, level = most_of_all + logarithm<T>(sum_of_all);
        for (int i = 0; i < m; ++i) probability[i] = probability[i] * over, log_total[i] = log_total[i] - level;
    }

    // Each mode's smoothed estimate over its pairs, matched in two moments, and its message.
    //
    // Where the pairs disagree the averaged message would be too sure of itself: its covariance grows by their spread about the
    // smoothed mean, its peak stays. Its level is such that under the filtered estimate it weighs what its pairs weigh together.
    void collapse() {
        const int m = c.count;
        for (int i = 0; i < m; ++i) {
            T *x = &arena[c.modes[i].place];
            T *P = covariances ? x + c.modes[i].shape.n : nullptr;
            kernels[i].merge(&pairs[i * m], m, x, P, messages[i].J, messages[i].h, &spread[i * m * L]);
        }
        for (int i = 0; i < m; ++i) kernels[i].root(messages[i], roots[i]);
        for (int i = 0; i < m; ++i) kernels[i].spread(&spread[i * m * L], m - 1, roots[i], messages[i].J, messages[i].h);
        for (int i = 0; i < m; ++i)
            messages[i].s = log_total[i] - log_now[i] - kernels[i].level(factor(i), messages[i].J, messages[i].h);
    }

    // A track whose next scan has nothing to do with this one ends here: its estimate is the filtered one, to the bit.
    void end_where_unlinked(const Record<T> &now, Mask<T> linked) {
        if (all(linked)) return;
        for (int i = 0; i < c.count; ++i) {
            const Mode<T> &mode = c.modes[i];
            for (int k = mode.place; k < mode.place + mode.size(); ++k) arena[k] = select<T>(linked, arena[k], now.arena[k]);
            probability[i] = select<T>(linked, probability[i], now.probability[i]);
            keep(i, messages[i], linked);
        }
    }

    // Where every number of every mode is. A message beyond the range of numbers is dropped: the filtered estimate stays.
    Mask<T> finite() const {
        T sum = splat<T>(0.0);
        for (int i = 0; i < c.count; ++i) {
            const T *x = &arena[c.modes[i].place];
            sum = sum + kernels[i].unsound(x, x + c.modes[i].shape.n, messages[i]) + probability[i] * 0.0;
        }
        return inverse(is_nan(sum));
    }

    void lay_out_routes();
};

template <class T>
Smooth<T>::Smooth(const Composition<T> &composition)
    : c(composition), forward(c), one(c), messages(c.count), next(c.count), roots(c.count), routes(c.count * c.count), pairs(c.count * c.count),
      log_total(c.count), log_transition(c.count * c.count), log_now(c.count), factors(c.count * packed_size(L)),
      spread(c.count * c.count * L), seen_dt(nan_of<T>()) {
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
    for (auto &m : messages) m = Message<T>();
}

template <class T> void Smooth<T>::last(const Record<T> &record, Mask<T> lanes_of_it) {
    for (std::size_t k = 0; k < arena.size(); ++k) arena[k] = select<T>(lanes_of_it, record.arena[k], arena[k]);
    for (std::size_t k = 0; k < probability.size(); ++k) probability[k] = select<T>(lanes_of_it, record.probability[k], probability[k]);
    for (auto &m : messages) m.keep(inverse(lanes_of_it));
}

template <class T> void Smooth<T>::step(const Record<T> &now, const Record<T> &after) {
    const int m = c.count;
    if (m == 1) {
        one.step(now, after, &arena[c.modes[0].place]);
        return;
    }
    next.swap(messages);
    const T dt = select<T>(after.linked, after.dt, splat<T>(0.0));
    forward.elapse(dt);
    if (!all(dt == seen_dt))
        for (int k = 0; k < m * m; ++k) log_transition[k] = logarithm<T>(larger<T>(forward.transition()[k], splat<T>(1e-300)));
    seen_dt = dt;
    add_measurements(after);
    blur(after);
    for (int j = 0; j < m; ++j)
        for (int i = 0; i < m; ++i) hear(now, after, i, j);
    fuse(now);
    share_out();
    collapse();
    end_where_unlinked(now, after.linked);
    end_where_unlinked(now, finite());
}

}  // namespace jink::inline JINK_LEVEL
