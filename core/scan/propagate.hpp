// From the last scan to the next: propose which modes are alive, mix their past estimates, predict, adapt the noise.
#pragma once

#include "scan/coasting.hpp"
#include "scan/propose.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class Propagate {
  public:
    explicit Propagate(const Composition<T> &composition);

    const Composition<T> &c;
    std::vector<T> predicted;   // each mode's x- and P-, at the mode's place
    std::vector<T> prior;       // mode probabilities before the measurement
    std::vector<T> pairs, pair_prior;  // GPB2: of mode i before and j now, at j * count + i
    int stride = 0;             // numbers from one pair to the next
    std::vector<T> inputs;      // known accelerations of each mode in this scan, where they vary

    bool pairwise() const { return c.declared.interaction == Interaction::gpb2; }

    // Elapsed-time coefficients and transition matrix; kept while the step stays the same.
    void elapse(T dt);
    // The same as another's, of the same filter: nothing is worked out twice.
    void elapse_as(Propagate &other, T dt) {
        if (c.varying || c.proposes() || all(dt == last_dt)) return;
        other.elapse(dt);
        last_dt = dt, coefficients = other.coefficients, pi = other.pi;
    }
    const T *coefficient(int j) const { return &coefficients[j * largest_coefficients]; }
    // Of all modes those of this scan, the noise that was asked for included; nothing where they do not vary.
    void used(std::vector<T> &out) const {
        if (!c.varying) return;
        out = coefficients;
        for (int j = 0; j < int(c.modes.size()); ++j) {
            const Mode<T> &mode = c.modes[j];
            const int from = j * largest_coefficients + mode.kernels.noise_at;
            if (mode.adapt.active()) std::copy_n(&noises[from], mode.shape.axes * mode.kernels.noise_terms, &out[from]);
        }
    }
    Coast<T> coast;
    Coasted<T> coasted;         // of the last step
    const T *transition() const { return pi.data(); }
    Proposal<T> proposal;

    // Over dt with the known acceleration of each axis (or null); `fix` is the position about to be used by modes that adapt.
    void operator()(TrackState<T> &s, T dt, const T *input, const Fix<T> *fix);

    // The same from the same state as if nothing had been measured, in some lanes: modes that adapt to residuals keep their noise.
    void again_without_fix(TrackState<T> &s, const T *input, Mask<T> which) {
        const std::vector<T> taken = predicted, asked = noises;
        (*this)(s, last_dt, input, nullptr);
        for (std::size_t k = 0; k < taken.size(); ++k) predicted[k] = select<T>(which, predicted[k], taken[k]);
        for (std::size_t k = 0; k < asked.size(); ++k) noises[k] = select<T>(which, noises[k], asked[k]);
    }

    // Multiplies the predicted covariances of all modes, and of their pairs.
    void widen(T by) {
        for (int j = 0; j < c.count; ++j) {
            const int n = c.modes[j].shape.n;
            for (int k = n; k < c.modes[j].size(); ++k) {
                predicted[c.modes[j].place + k] = predicted[c.modes[j].place + k] * by;
                for (int i = 0; pairwise() && i < c.count; ++i) {
                    T &covariance = pairs[(j * c.count + i) * stride + k];
                    covariance = covariance * by;
                }
            }
        }
    }

    // GPB2's pairs as one prediction per mode, for those who look at it.
    void merge_pairs();
    // Mode j's pairs by `weights`, matched in two moments.
    void merge(int j, const T *from, T *out, const T *by = nullptr) const {
        const int *places = &pair_places[j * c.count * stride];
        mix_kernel<T, true>(c.modes[j].shape.n)(from, places, by ? by : weights.data(), c.count, out);
    }

  private:
    std::vector<T> pi, weights, coefficients, units, noises;  // of modes that adapt: for unit variances, and for those of this scan
    std::vector<int> pair_places;  // of each mode: where its pairs lie among its own, as a mix kernel reads them
    T last_dt;
    bool adapts = false;

    void prepare(int j, T dt, const T *parameters) {
        const Mode<T> &mode = c.modes[j];
        mode.kernels.prepare(mode.motion, dt, parameters, &coefficients[j * largest_coefficients]);
        if (!mode.adapt.active()) return;
        T *unit = &units[j * largest_coefficients];
        mode.kernels.prepare(mode.motion, dt, mode.unit.data(), unit);
        std::copy_n(unit, largest_coefficients, &noises[j * largest_coefficients]);
    }

    // The slots' modes of this scan and how they follow from those of the last.
    void take_up(TrackState<T> &s, T dt) {
        proposal.choose(s, dt);
        proposal.transition(s, dt, pi.data());
        for (int j = 0; j < c.count; ++j)
            if (proposal.numbers.load(s, j)) prepare(j, dt, proposal.numbers.parameters(j));
    }

    // prior = Pi' mu, and w_ij = Pi_ij mu_i / prior_j; GPB1 starts every mode from the combined estimate, w_ij = mu_i.
    void weigh_sources(const TrackState<T> &s) {
        const int m = c.count;
        const T least = splat<T>(1e-100), zero = splat<T>(0.0), one = splat<T>(1.0);  // a mode never dies for good
        for (int j = 0; j < m; ++j) prior[j] = zero;
        for (int i = 0; i < m; ++i) {
            T mu = larger<T>(s.probability[i], least);
            if (c.proposes()) mu = select<T>(living(s.alive[i]), mu, zero);
            for (int j = 0; j < m; ++j) weights[j * m + i] = pi[i * m + j] * mu, prior[j] = prior[j] + weights[j * m + i];
        }
        if (pairwise()) {
            for (int k = 0; k < m * m; ++k) pair_prior[k] = weights[k];
            return;
        }
        for (int j = 0; j < m; ++j) {
            const Mask<T> reached = c.proposes() ? prior[j] > zero : splat_mask<T>(true);
            const T over = reciprocal(c.proposes() ? select<T>(reached, prior[j], one) : prior[j]);
            for (int i = 0; i < m; ++i)
                weights[j * m + i] = c.declared.interaction == Interaction::gpb1 ? s.probability[i] : weights[j * m + i] * over;
            for (int i = 0; c.proposes() && !all(reached) && i < m; ++i)  // a mode that nothing led to starts from all alike
                weights[j * m + i] = select<T>(reached, weights[j * m + i], s.probability[i]);
        }
    }

    void predict_pairs(TrackState<T> &s, const T *input, const Fix<T> *fix) {
        const int m = c.count;
        for (int j = 0; j < m; ++j)
            for (int i = 0; i < m; ++i) {
                const Mode<T> &mode = c.modes[j];
                const int *places = &mode.sources[i * mode.size()];
                T *at = &pairs[(j * m + i) * stride];
                for (int k = 0; k < mode.size(); ++k) at[k] = s.arena[places[k]];
                predict(s, j, at, at, input, fix);
            }
    }

    void predict(TrackState<T> &s, int j, const T *in, T *out, const T *input, const Fix<T> *fix) {
        if (!coast.active()) return move(s, j, in, out, input, fix);
        const Mode<T> &mode = c.modes[j];
        T from[largest_state];  // `in` and `out` may be one
        for (int k = 0; k < mode.shape.n; ++k) from[k] = in[k];
        move(s, j, in, out, input, fix);
        coast(mode, last_dt, coasted, from, out);
    }

    static void run(const Mode<T> &mode, const T *in, const T *coefficients, const T *input, T *out) {
        if constexpr (WithSlopes<T>)
            if (mode.kernels.slope && without_slopes(coefficients, mode.kernels.noise_at))
                return predict_slopes(mode.kernels, mode.shape.axes, mode.size(), in, coefficients, input, out);
        mode.kernels.predict(in, coefficients, input, out);
    }

    void move(TrackState<T> &s, int j, const T *in, T *out, const T *input, const Fix<T> *fix) {
        const Mode<T> &mode = c.modes[j];
        if (!c.varying && !c.proposes()) return run(mode, in, coefficient(j), input, out);
        const int axes = mode.shape.axes;
        T known[3];
        const T *level = c.proposes() ? proposal.numbers.level(j) : mode.level.empty() ? nullptr : mode.level.data();
        const Mode<T> *side = mode.around_side ? c.side() : nullptr;
        if (level || side) {
            for (int a = 0; a < axes; ++a) {
                known[a] = input ? input[a] : splat<T>(0.0);
                T offset = level ? level[a] : splat<T>(0.0);
                if (side && mode.in_sd) {
                    const T variance = s.arena[side->place + side->shape.n + packed(3 * a + 2, 3 * a + 2)];
                    offset = offset * square_root(larger<T>(variance, splat<T>(1e-300)));
                }
                known[a] = known[a] + offset;
                if (side) known[a] = known[a] + s.arena[side->place + 3 * a + 2];
            }
            input = known;
        }
        run(mode, in, coefficient(j), input, out);
        if (mode.adapt.active()) adapt(s, j, fix, out);
        for (int a = 0; c.varying && a < axes; ++a) inputs[j * 3 + a] = input ? input[a] : splat<T>(0.0);
    }

    // Adds the noise that the mode asks for.
    void adapt(TrackState<T> &s, int j, const Fix<T> *fix, T *at) {
        const Mode<T> &mode = c.modes[j];
        const T *unit = &units[j * largest_coefficients];
        T *noise = &noises[j * largest_coefficients];
        const int axes = mode.shape.axes, from = mode.kernels.noise_at, terms = mode.kernels.noise_terms;
        T variance[3], position[3], ratio[3];
        for (int a = 0; a < axes; ++a) position[a] = unit[from + a * terms];
        mode.adapt(at, mode.shape.block, axes, mode.shape.n, position, fix, s.carry.data() + mode.carry, variance, ratio);
        for (int a = 0; a < axes; ++a)
            for (int k = from + a * terms; k < from + (a + 1) * terms; ++k) noise[k] = variance[a] * unit[k];
        for (int pair = 0; mode.kernels.turned_noise && pair < axes * (axes - 1) / 2; ++pair) noise[from + pair * terms + terms - 1] = ratio[pair];
        mode.kernels.add_noise(noise, at + mode.shape.n);
    }
};

template <class T> Propagate<T>::Propagate(const Composition<T> &composition)
    : c(composition), coast(composition.declared.coasting), coasted{splat<T>(0.0), splat<T>(0.0)}, proposal(composition) {
    const int m = c.count, all = int(c.modes.size());
    predicted.resize(c.arena_size);
    pi.resize(m * m), weights.resize(m * m), prior.resize(m);
    coefficients.resize(all * largest_coefficients);
    for (const auto &mode : c.modes) adapts = adapts || mode.adapt.active();
    if (adapts) units.resize(all * largest_coefficients), noises.resize(all * largest_coefficients);
    if (c.varying) inputs.resize(all * 3);
    last_dt = nan_of<T>();
    if (!pairwise()) return;
    for (const auto &mode : c.modes) stride = std::max(stride, mode.size());
    pairs.resize(m * m * stride), pair_prior.resize(m * m), pair_places.resize(m * m * stride);
    for (int j = 0; j < m; ++j)
        for (int i = 0; i < m; ++i) pair_places[j * m * stride + i * c.modes[j].size()] = i * stride;
}

template <class T> void Propagate<T>::elapse(T dt) {
    if (all(dt == last_dt)) return;
    last_dt = dt;
    for (int j = 0; j < int(c.modes.size()); ++j)
        prepare(j, dt, c.proposes() && j < c.count ? proposal.numbers.parameters(j) : c.modes[j].parameters.data());
    if (!c.proposes()) c.switching.over(dt, pi.data(), weights.data());
}

template <class T> void Propagate<T>::operator()(TrackState<T> &s, T dt, const T *input, const Fix<T> *fix) {
    elapse(dt);
    if (coast.active()) coasted = coast.over(s, dt);
    if (c.proposes()) take_up(s, dt);
    const int m = c.count;
    if (m == 1) {
        prior[0] = splat<T>(1.0);
        predict(s, 0, &s.arena[c.modes[0].place], &predicted[c.modes[0].place], input, fix);
    } else if (pairwise()) {
        weigh_sources(s);
        predict_pairs(s, input, fix);
    } else {
        weigh_sources(s);
        for (int j = 0; j < m; ++j) {
            if (c.proposes() && !any(living(s.next[j]))) continue;
            const Mode<T> &mode = c.modes[j];
            T *at = &predicted[mode.place];
            if (c.declared.interaction == Interaction::none) {
                predict(s, j, &s.arena[mode.place], at, input, fix);
                continue;
            }
            if (mode.alike && mode.kernels.mix_predict && !coast.active() && !c.varying && !c.proposes()) {
                mode.kernels.mix_predict(s.arena.data(), mode.sources.data(), &weights[j * m], m, coefficient(j), input, at);
                continue;
            }
            mode.mix(s.arena.data(), mode.sources.data(), &weights[j * m], m, at);
            predict(s, j, at, at, input, fix);
        }
    }
    if (const Mode<T> *side = c.side()) side->kernels.predict(&s.arena[side->place], coefficient(m), input, &predicted[side->place]);
}

template <class T> void Propagate<T>::merge_pairs() {
    const int m = c.count;
    for (int j = 0; pairwise() && j < m; ++j) {
        const T over = reciprocal(prior[j]);
        for (int i = 0; i < m; ++i) weights[i] = pair_prior[j * m + i] * over;
        merge(j, &pairs[j * m * stride], &predicted[c.modes[j].place]);
    }
}

}  // namespace jink::inline JINK_LEVEL
