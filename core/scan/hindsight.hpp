// Outliers decided with hindsight: where a measurement may be the target's or not, both are followed until the next one.
//
//   p = (1 − ε) N / ((1 − ε) N + ε / V)     that it is the target's, N its density over all modes
//
// Where p and 1 − p both exceed `least`, the track goes on as two banks of modes: one that was updated, with weight p, and one that
// was not, with 1 − p. What goes out are both, matched in two moments. The next measurement has the density Σ w_h N_h. Weighed by
// w_h N_h the updated banks become one again, mode by mode; weighed by w_h so do the predicted ones, which is what remains if
// that measurement is an outlier. Then the next doubt may begin. Scans without a measurement decide nothing. A measurement that
// surprise.hpp explains is believed at once.
#pragma once

#include "scan/consistency.hpp"
#include "scan/propagate.hpp"

namespace jink::inline JINK_LEVEL {

// Adds to bank a the share `b` of the bank at (arena, probability), mode by mode, in some lanes.
template <class T>
void merge_banks(const Composition<T> &c, Mask<T> lanes_of_it, T b, T *arena, T *probability, const T *other, const T *other_probability) {
    for (int j = 0; j < c.count; ++j) {
        const Mode<T> &mode = c.modes[j];
        const int n = mode.shape.n;
        T *x = arena + mode.place, *P = x + n, d[largest_state];
        const T *y = other + mode.place, *Q = y + n;
        const T theirs = b * other_probability[j], both = (1.0 - b) * probability[j] + theirs;
        const T f = select<T>(both > splat<T>(1e-300), theirs / larger<T>(both, splat<T>(1e-300)), b), kept = 1.0 - f;
        for (int r = 0; r < n; ++r) d[r] = y[r] - x[r];
        for (int r = 0; r < n; ++r)
            for (int k = 0; k <= r; ++k) {
                const int at = packed(r, k);
                P[at] = select<T>(lanes_of_it, kept * P[at] + f * Q[at] + f * kept * d[r] * d[k], P[at]);
            }
        for (int r = 0; r < n; ++r) x[r] = select<T>(lanes_of_it, x[r] + f * d[r], x[r]);
        probability[j] = select<T>(lanes_of_it, both, probability[j]);
    }
}

template <class T> class Hindsight {
  public:
    explicit Hindsight(const Composition<T> &composition);

    static constexpr double least = 1e-6;  // probability of what is not followed

    bool active() const { return c.declared.hindsight; }
    bool two() const { return following; }

    Propagate<T> ahead;                   // of the bank that was not updated with the measurement in doubt
    TrackState<T> state;
    std::vector<Innovation<T>> innovations;

    // A scan begins. In the lanes in doubt s becomes the bank that was updated, which `mine` is about to predict.
    void part(TrackState<T> &s, Propagate<T> &mine, Mask<T> going, T dt, const T *input) {
        s.doubt = select<T>(s.running & going, s.doubt, splat<T>(0.0));
        weight = s.doubt;
        const Mask<T> lanes_in_doubt = weight > splat<T>(0.0);
        following = any(lanes_in_doubt);
        if (!following) return;
        recall(s.believed, lanes_in_doubt, s);
        // the banks that were kept are large, and nothing of the other bank asks for them
        std::vector<T> believed = std::move(s.believed), doubted = std::move(s.doubted);
        state = s;
        s.believed = std::move(believed), s.doubted = std::move(doubted);
        recall(s.doubted, lanes_in_doubt, state);
        ahead.elapse_as(mine, dt);
        ahead(state, dt, input, nullptr);
    }

    // The modes of both banks, for what is measured over all of them.
    Hypotheses<T> joined(const Hypotheses<T> &mine) {
        const int m = mine.count;
        for (int j = 0; j < m; ++j) {
            prior[j] = (1.0 - weight) * mine.prior[j], prior[m + j] = weight * ahead.prior[j];
            both[j] = mine.innovations[j], both[m + j] = innovations[j];
        }
        return {2 * m, prior.data(), both.data()};
    }

    // Both banks have been updated; log-likelihoods of the measurement by this one and by the other. In the lanes that measured
    // something the banks become one, and so do their predictions; what was decided is said of the measurement in doubt.
    void settle(TrackState<T> &s, Propagate<T> &mine, Mask<T> here, T other, T log_outlier, Outcome<T> &out) {
        const T zero = splat<T>(0.0), one = splat<T>(1.0);
        const Mask<T> doubtful = here & (weight > zero), measured = doubtful & out.measured, waiting = doubtful & inverse(out.measured);
        const T w = select<T>(doubtful, weight, splat<T>(0.5));
        const auto sane = [&](T l) { return select<T>(magnitude(l) <= splat<T>(farthest), l, splat<T>(-farthest)); };
        const T log_a = logarithm<T>(one - w), log_b = logarithm<T>(w);
        const T a = sane(out.log_likelihood) + log_a, b = sane(other) + log_b, high = larger<T>(a, b);
        const T of_b = exponential<T>(b - high), sum = exponential<T>(a - high) + of_b;
        const T outlier = log_outlier + c.log_outlier_share;
        const auto either_way = [&](T target, T prior) {  // log density of the measurement, the target's or not
            const T t = target + c.log_target_share, o = outlier + prior, top = larger<T>(t, o);
            return top + logarithm<T>(1.0 + exponential<T>(smaller<T>(t, o) - top));
        };
        out.decided = measured;
        out.upheld = measured & inverse(either_way(a, log_a) < either_way(b, log_b));
        if (any(waiting)) {
            keep(s.arena, s.probability, waiting, s.believed);
            keep(ahead.predicted, ahead.prior, waiting, s.doubted);
        }
        const Mask<T> possible = magnitude(out.log_likelihood) <= splat<T>(farthest);
        const T share = select<T>(measured, select<T>(possible | (magnitude(other) <= splat<T>(farthest)), of_b / sum, zero), w);
        merge_banks(c, doubtful, share, s.arena.data(), s.probability.data(), state.arena.data(), state.probability.data());
        merge_banks(c, doubtful, w, mine.predicted.data(), mine.prior.data(), ahead.predicted.data(), ahead.prior.data());
        const Mask<T> either = measured & (possible | (magnitude(other) <= splat<T>(farthest)));
        out.log_likelihood = select<T>(either, high + logarithm<T>(sum), out.log_likelihood);
        s.doubt = select<T>(measured, zero, s.doubt);
    }

    // Are both explanations likely enough to be followed?
    Mask<T> doubts(T target, T outlier) const { return magnitude(target - outlier) < splat<T>(most_lead); }

    // The lanes in which both are followed from here on: their banks are kept, before s becomes one of them.
    Mask<T> begin(TrackState<T> &s, const Propagate<T> &mine, Mask<T> may, T target, T outlier) const {
        const T lead = target - outlier;
        const Mask<T> doubtful = may & doubts(target, outlier);
        if (!any(doubtful)) return doubtful;
        s.doubt = select<T>(doubtful, 1.0 / (1.0 + exponential<T>(select<T>(doubtful, lead, splat<T>(0.0)))), s.doubt);
        keep(s.arena, s.probability, doubtful, s.believed);
        keep(mine.predicted, mine.prior, doubtful, s.doubted);
        return doubtful;
    }

    // A measurement that is upheld was accepted when it was made; one that is now in doubt may be. `height`: its third axis is known.
    void date(TrackState<T> &s, const Outcome<T> &out, Mask<T> height) const {
        if (any(out.upheld)) {
            s.last_accepted = select<T>(out.upheld, larger<T>(s.last_accepted, s.in_doubt), s.last_accepted);
            s.last_height = select<T>(out.upheld, larger<T>(s.last_height, s.height_in_doubt), s.last_height);
        }
        const Mask<T> fresh = out.measured & (s.doubt > splat<T>(0.0));
        if (!any(fresh)) return;
        s.in_doubt = select<T>(fresh, s.time, s.in_doubt);
        s.height_in_doubt = select<T>(fresh, select<T>(height, s.time, s.last_height), s.height_in_doubt);
    }

    // What goes out while both are followed. In the lanes that were not gated s still is the bank that was updated.
    void blend(TrackState<T> &s, Mask<T> doubtful, Mask<T> gated) const {
        if (any(doubtful & gated)) recall(s.believed, doubtful, s);
        merge_banks(c, doubtful, s.doubt, s.arena.data(), s.probability.data(), s.doubted.data(), s.doubted.data() + c.arena_size);
    }

  private:
    static constexpr double most_lead = 13.815510557964274;  // −log(least)
    static constexpr double farthest = 1e100;                 // a log-likelihood beyond says nothing

    const Composition<T> &c;
    bool following = false;
    T weight;
    std::vector<T> prior;
    std::vector<Innovation<T>> both;

    // A bank as one row of numbers: the arena, of which the modes count, then the probabilities.
    void keep(const std::vector<T> &arena, const std::vector<T> &probability, Mask<T> which, std::vector<T> &to) const {
        for (int k = c.modes[0].place; k < c.arena_size; ++k) to[k] = select<T>(which, arena[k], to[k]);
        for (int j = 0; j < c.count; ++j) to[c.arena_size + j] = select<T>(which, probability[j], to[c.arena_size + j]);
    }
    void recall(const std::vector<T> &from, Mask<T> which, TrackState<T> &s) const {
        for (int k = c.modes[0].place; k < c.arena_size; ++k) s.arena[k] = select<T>(which, from[k], s.arena[k]);
        for (int j = 0; j < c.count; ++j) s.probability[j] = select<T>(which, from[c.arena_size + j], s.probability[j]);
    }
};

template <class T>
Hindsight<T>::Hindsight(const Composition<T> &composition) : ahead(composition), state(composition), c(composition), weight(splat<T>(0.0)) {
    if (!active()) return;
    innovations.resize(c.count), both.resize(2 * c.count), prior.resize(2 * c.count);
    for (auto &v : innovations) {
        v = Innovation<T>();
        v.det = splat<T>(1.0);
        for (auto &S : v.S) S = splat<T>(1.0);
    }
}

}  // namespace jink::inline JINK_LEVEL
