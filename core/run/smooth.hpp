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
    // Of a pair of modes: which of mode j's components enter, and where it passes.
    struct Route {
        int entering[most_entering], count = 0, passage = 0;
        bool first = true, alike = true;   // the first pair of its passage; both modes have the same components
        bool constant = true;              // what enters has the same covariance in every scan:
        T prior[packed_size(most_entering)];  // its root
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
    std::vector<T> most, total;  // of each mode: its pairs' weights together are exp(most) * total
    std::vector<T> weights;      // of one mode's pairs, twice
    std::vector<T> factors;      // Cholesky factors of the filtered covariances
    std::vector<T> spread;       // of each mode: its pairs about its mean, column by column

    const T *coefficient(const Record<T> &after, int j) const {
        return after.coefficients.empty() ? forward.coefficient(j) : &after.coefficients[j * largest_coefficients];
    }
    int shared() const { return 2 * c.declared.axes(); }  // components that modes of all kinds have
    const T *factor(int i) const { return &factors[i * packed_size(L)]; }

    // What the scan after measured, as seen by each mode; messages become empty where the track begins with that scan.
    void add_measurements(const Record<T> &after) {
        add_measurement(after, c.sensors[after.sensor], after.measurement);
        for (int k = 0; k < int(after.others.size()); ++k) add_measurement(after, c.sensors[k + 1], after.others[k]);
        for (int j = 0; j < c.count && !all(after.linked); ++j) keep(j, next[j], after.linked);
    }

    void add_measurement(const Record<T> &after, const Sensor<T> &sensor, const Measurement<T> &z) {
        const SensorSpec spec = seen(sensor);
        const bool direct = spec.linear();
        T weight[packed_size(largest_measurement)];
        if (direct) weigh_components(spec, z, weight);
        for (int j = 0; j < c.count; ++j) {
            const Mode<T> &mode = c.modes[j];
            const T *x = &after.arena[mode.place];
            if (direct) add_components(mode, x, spec, z, weight, next[j]);
            else add_rows(mode, x, spec, z, next[j]);
        }
    }

    // A message in some lanes, none in the others.
    void keep(int j, Message<T> &m, Mask<T> lanes_with_it) const {
        const int n = c.modes[j].shape.n;
        const T zero = splat<T>(0.0);
        for (int k = 0; k < packed_size(n); ++k) m.J[k] = select<T>(lanes_with_it, m.J[k], zero);
        for (int k = 0; k < n; ++k) m.h[k] = select<T>(lanes_with_it, m.h[k], zero);
        m.s = select<T>(lanes_with_it, m.s, zero);
        for (T *factor : {&m.rest, &m.grown}) *factor = select<T>(lanes_with_it, *factor, splat<T>(1.0));
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

    void advance(const Record<T> &after, int j, const T *start, T *ahead) {
        c.modes[j].kernels.advance(start, coefficient(after, j), after.input_of(j), ahead);
        coast(after, j, start, ahead);
    }

    void coast(const Record<T> &after, int j, const T *start, T *ahead) {
        if (!forward.coast.active()) return;
        forward.coast(c.modes[j], select<T>(after.linked, after.dt, splat<T>(0.0)), after.coasted, start, ahead);
    }

    // Mode j's message through the motion from a state as mode j sees it.
    void open(Passage<T> &to, const Route &route, const Record<T> &after, int j, const T *start) {
        const Mode<T> &mode = c.modes[j];
        const SmoothKernels<T> &kernel = kernels[j];
        const int n = mode.shape.n;
        T ahead[L];
        to.root = &roots[j];
        if (mode.kernels.regressed) {
            T F[L * L], Q[packed_size(L)];
            mode.kernels.linearise(start, coefficient(after, j), after.input_of(j), ahead, F, Q);
            coast(after, j, start, ahead);
            to.own = roots[j], to.root = &to.own;
            kernel.blur(Q, to.own);
            kernel.pull(to.own.R, F, to.B);
        } else {
            mode.kernels.pull(start, coefficient(after, j), to.root->R, to.B);
            advance(after, j, start, ahead);
        }
        to.s = to.root->s, to.rest = to.root->rest;
        if (route.count) enter(to, route, kernel, n, start + n);
        kernel.gram[route.alike](to.B, to.J);
        std::copy_n(start, n, to.start);
        kernel.listen(ahead, &after.arena[mode.place], route.count, to);
    }

    // What mode i does not have enters with its prior covariance: noise V V' of the start, in B along B V.
    void enter(Passage<T> &to, const Route &route, const SmoothKernels<T> &kernel, int n, const T *P) {
        T own[packed_size(most_entering)];
        if (!route.constant) root_of_entering(route, P, own);
        const T *root = route.constant ? route.prior : own;
        for (int k = 0; k < route.count; ++k) {
            T *v = &to.v[k * L];
            for (int r = 0; r < n; ++r) {
                v[r] = to.B[r * n + route.entering[k]] * root[packed(k, k)];
                for (int l = k + 1; l < route.count; ++l) v[r] = v[r] + to.B[r * n + route.entering[l]] * root[packed(l, k)];
            }
            const Scaled<T> less = scaled<T>(kernel.enter(v, k + 1, to.B, to.scale[k]));
            to.s = to.s + less.log, to.rest = to.rest * less.rest;
        }
    }

    static void root_of_entering(const Route &route, const T *P, T *root) {
        T V[packed_size(most_entering)];
        for (int r = 0; r < route.count; ++r)
            for (int k = 0; k <= r; ++k) V[packed(r, k)] = P[packed(route.entering[r], route.entering[k])];
        cholesky<T>(route.count, V, root);
    }

    // Mode j's message as mode i hears it.
    void hear(const Record<T> &now, const Record<T> &after, int i, int j) {
        const Mode<T> &mode = c.modes[j];
        const Route &route = routes[i * c.count + j];
        Passage<T> &passage = passages[route.passage];
        SmoothPair<T> &p = pairs[i * c.count + j];
        const int n = mode.shape.n, size = packed_size(n);
        const T *start = &now.arena[c.modes[i].place];
        T seen[L + packed_size(L)];
        if (!route.alike) {
            const bool covariance = route.first && ((route.count && !route.constant) || mode.kernels.regressed);
            const int *places = &mode.sources[i * (n + size)];
            for (int k = 0; k < (covariance ? n + size : n); ++k) seen[k] = now.arena[places[k]];
            start = seen;
        }
        if (route.first) open(passage, route, after, j, start);
        p.log_weight = kernels[j].hear[route.alike](passage, route.first ? nullptr : start, p.h);
        if (!route.first) hear_bent(after, i, j, start, p.h);
        p.J = passage.J, p.share = passage.rest;
    }

    // The same where the motion from this start is not what F says: where coasting bends it, and where the mean acceleration is taken
    // for known, so that a state moves otherwise than its errors.
    void hear_bent(const Record<T> &after, int i, int j, const T *start, T *h) {
        const MotionKind kind = c.modes[j].motion.kind;
        Mask<T> bent = forward.coast.bends(c.modes[j], after.coasted);
        if (kind == MotionKind::current_statistical || kind == MotionKind::statistical_along_track) bent = splat_mask<T>(true);
        if (!any(bent)) return;
        const Route &route = routes[i * c.count + j];
        Passage<T> &passage = passages[route.passage];
        T ahead[L], kept[L], own[L], &s = pairs[i * c.count + j].log_weight;
        std::copy_n(passage.c, L, kept);
        advance(after, j, start, ahead);
        kernels[j].listen(ahead, &after.arena[c.modes[j].place], route.count, passage);
        s = select<T>(bent, kernels[j].hear[route.alike](passage, nullptr, own), s);
        for (int k = 0; k < (route.alike ? c.modes[j].shape.n : shared()); ++k) h[k] = select<T>(bent, own[k], h[k]);
        std::copy_n(kept, L, passage.c);
    }

    void fuse(const Record<T> &now) {
        const int m = c.count;
        for (int i = 0; i < m; ++i) {
            const Mode<T> &mode = c.modes[i];
            kernels[i].factor(&now.arena[mode.place + mode.shape.n], &factors[i * packed_size(L)]);
        }
        for (int i = 0; i < m; ++i)
            for (int j = 0; j < m; ++j) {
                SmoothPair<T> &p = pairs[i * m + j];
                const T *x = &now.arena[c.modes[i].place];
                const Scaled<T> mean = kernels[i].fuse[p.whole](factor(i), p.J, p.h, x, p.x, covariances ? p.P : nullptr);
                const Scaled<T> link = scaled<T>(larger<T>(forward.transition()[i * m + j] * now.probability[i], splat<T>(1e-300)));
                p.log_weight = link.log + p.log_weight + mean.log, p.share = link.rest * p.share * mean.rest;
            }
    }

    // Each pair's weight over exp(reference); returns their sum.
    T weigh(int i, T reference, T *weight) const {
        T sum = splat<T>(0.0);
        for (int j = 0; j < c.count; ++j) {
            const SmoothPair<T> &p = pairs[i * c.count + j];
            weight[j] = p.share * exponential<T>(p.log_weight - reference), sum = sum + weight[j];
        }
        return sum;
    }

    // Each pair's share of its first mode's weight, and each mode's probability. All weights are over the largest of any pair; in
    // lanes where that leaves nothing of a mode, over the largest of its own.
    void share_out() {
        const int m = c.count;
        T most_of_all = pairs[0].log_weight, sum_of_all = splat<T>(0.0);
        for (int k = 1; k < m * m; ++k) most_of_all = larger<T>(most_of_all, pairs[k].log_weight);
        for (int i = 0; i < m; ++i) {
            total[i] = weigh(i, most_of_all, weights.data()), most[i] = splat<T>(0.0), probability[i] = total[i];
            const Mask<T> faint = total[i] < splat<T>(1e-200);
            if (any(faint)) weigh_faint(i, most_of_all, faint);
            const T over = reciprocal(total[i]);
            for (int j = 0; j < m; ++j) pairs[i * m + j].share = weights[j] * over;
            sum_of_all = sum_of_all + probability[i];
        }
        const T over = reciprocal(sum_of_all);
        for (int i = 0; i < m; ++i) probability[i] = probability[i] * over, total[i] = total[i] * over;
    }

    [[gnu::noinline]] void weigh_faint(int i, T most_of_all, Mask<T> faint) {
        const int m = c.count;
        T *own = weights.data() + m, most_of_own = pairs[i * m].log_weight;
        for (int j = 1; j < m; ++j) most_of_own = larger<T>(most_of_own, pairs[i * m + j].log_weight);
        total[i] = select<T>(faint, weigh(i, most_of_own, own), total[i]);
        for (int j = 0; j < m; ++j) weights[j] = select<T>(faint, own[j], weights[j]);
        most[i] = select<T>(faint, most_of_own - most_of_all, most[i]);
        probability[i] = select<T>(faint, exponential<T>(most[i]) * total[i], probability[i]);
    }

    // Each mode's smoothed estimate over its pairs, matched in two moments, and its message.
    //
    // Where the pairs disagree the averaged message would be too sure of itself: its covariance grows by their spread about the
    // smoothed mean, its peak stays. Its level is such that under the filtered estimate it weighs what its pairs weigh together.
    void collapse(const Record<T> &now) {
        const int m = c.count;
        for (int i = 0; i < m; ++i) {
            T *x = &arena[c.modes[i].place], *P = covariances ? x + c.modes[i].shape.n : nullptr;
            kernels[i].merge(&pairs[i * m], m, x, P, messages[i].J, messages[i].h, &spread[i * m * L]);
        }
        for (int i = 0; i < m; ++i) widen(i);
        for (int i = 0; i < m; ++i) {
            const Scaled<T> mean = kernels[i].level(factor(i), messages[i].J, messages[i].h);
            const Scaled<T> weight = scaled<T>(total[i] / (mean.rest * larger<T>(now.probability[i], splat<T>(1e-300))));
            messages[i].s = most[i] - mean.log + weight.log, messages[i].rest = weight.rest;
        }
    }

    // Mode i's message is spread as its pairs are. Where subtraction loses too many digits it is done by roots.
    void widen(int i) {
        constexpr double most_grown = 1e3;
        Message<T> &message = messages[i], whole;
        const T *V = &spread[i * c.count * L];
        message.grown = kernels[i].thin(V, c.count - 1, message.J, message.h);
        const Mask<T> lost = inverse(message.grown <= splat<T>(most_grown));
        if (!any(lost)) return;
        const int n = c.modes[i].shape.n;
        T x[L];
        kernels[i].merge(&pairs[i * c.count], c.count, x, nullptr, whole.J, whole.h, &spread[i * c.count * L]);
        whole.s = splat<T>(0.0), whole.rest = whole.grown = splat<T>(1.0);
        kernels[i].root(whole, roots[i]);
        kernels[i].spread(V, c.count - 1, roots[i], whole.J, whole.h);
        for (int k = 0; k < packed_size(n); ++k) message.J[k] = select<T>(lost, whole.J[k], message.J[k]);
        for (int k = 0; k < n; ++k) message.h[k] = select<T>(lost, whole.h[k], message.h[k]);
        message.grown = select<T>(lost, splat<T>(1.0), message.grown);
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
            sum = sum + kernels[i].unsound(x, covariances ? x + c.modes[i].shape.n : nullptr, messages[i]) + probability[i] * 0.0;
        }
        return inverse(is_nan(sum));
    }

    void lay_out_routes();
};

template <class T>
Smooth<T>::Smooth(const Composition<T> &composition)
    : c(composition), forward(c), one(c), messages(c.count), next(c.count), roots(c.count), routes(c.count * c.count), pairs(c.count * c.count),
      most(c.count), total(c.count), weights(2 * c.count), factors(c.count * packed_size(L)), spread(c.count * c.count * L) {
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
            for (int k = 0; k < to.shape.n; ++k)
                if (place_of(to.shape, k, from.shape) < 0) route.entering[route.count++] = k;
            route.alike = pairs[i * c.count + j].whole = from.shape.n == to.shape.n;
            route.constant = !c.declared.unbiased_mixing;
            for (int r = 0; r < route.count; ++r)
                for (int k = 0; k <= r; ++k)
                    route.prior[packed(r, k)] = r == k ? square_root(to.prior_variance[route.entering[r]]) : splat<T>(0.0);
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
    for (auto &m : messages) m = Message<T>(), m.rest = m.grown = splat<T>(1.0);
}

template <class T> void Smooth<T>::last(const Record<T> &record, Mask<T> lanes_of_it) {
    for (std::size_t k = 0; k < arena.size(); ++k) arena[k] = select<T>(lanes_of_it, record.arena[k], arena[k]);
    for (std::size_t k = 0; k < probability.size(); ++k) probability[k] = select<T>(lanes_of_it, record.probability[k], probability[k]);
    for (int i = 0; i < c.count; ++i) keep(i, messages[i], inverse(lanes_of_it));
}

template <class T> void Smooth<T>::step(const Record<T> &now, const Record<T> &after) {
    const int m = c.count;
    if (m == 1) {
        one.step(now, after, &arena[c.modes[0].place]);
        return;
    }
    next.swap(messages);
    forward.elapse(select<T>(after.linked, after.dt, splat<T>(0.0)));
    add_measurements(after);
    blur(after);
    for (int j = 0; j < m; ++j)
        for (int i = 0; i < m; ++i) hear(now, after, i, j);
    fuse(now);
    share_out();
    collapse(now);
    end_where_unlinked(now, after.linked);
    end_where_unlinked(now, finite());
}

}  // namespace jink::inline JINK_LEVEL
