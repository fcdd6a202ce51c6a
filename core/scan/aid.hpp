// A learned aid on top of a filter: along each axis by itself, a correction of the estimate that goes out, from what was just seen.
//
// Inputs: z - x(t|t) and x(t|t-1) - x(t|t), in metres (Titi & Guney); or the last innovations over their sd, the newest first, or their sums. The
// model is a perceptron or an adaptive network-based fuzzy inference system (Jang, IEEE Trans. SMC-23(3), 1993). Outside the range
// it was trained on the correction fades to nothing. The filter itself knows nothing of it: what goes out is x + c and W P W, W diagonal.
#pragma once

#include <cmath>

#include "scan/combine.hpp"
#include "scan/plane_corrector.hpp"
#include "scan/step.hpp"

namespace jink::inline JINK_LEVEL {

// y = sum_r h_r (A_r u + b_r) / sum_r h_r over a grid of membership functions, the last input's running fastest.
template <class T> class Anfis {
  public:
    Anfis() = default;
    Anfis(AidModel model, const std::vector<int> &functions, int outputs_, const T *from) : kind(model), counts(functions), outputs(outputs_) {
        const int parameters = kind == AidModel::gaussian ? 2 : 3;
        for (int n : counts) memberships.push_back({from, from + n * parameters}), from += n * parameters, rules *= n;
        consequents.assign(from, from + rules * outputs * (int(counts.size()) + 1));
    }

    void operator()(const T *u, T *y) const {
        const int inputs = int(counts.size());
        T grades[largest_layer], total = splat<T>(0.0);
        for (int i = 0, at = 0; i < inputs; at += counts[i++])
            for (int k = 0; k < counts[i]; ++k) grades[at + k] = grade(i, k, u[i]);
        for (int o = 0; o < outputs; ++o) y[o] = splat<T>(0.0);
        for (int r = 0; r < rules; ++r) {
            T h = splat<T>(1.0);
            for (int i = inputs - 1, rest = r, end = widths(); i >= 0; --i) {
                end -= counts[i];
                h = h * grades[end + rest % counts[i]], rest /= counts[i];
            }
            total = total + h;
            const T *row = &consequents[r * outputs * (inputs + 1)];
            for (int o = 0; o < outputs; ++o, row += inputs + 1) {
                T sum = row[inputs];
                for (int i = 0; i < inputs; ++i) sum = sum + row[i] * u[i];
                y[o] = y[o] + h * sum;
            }
        }
        const T over = 1.0 / larger<T>(total, splat<T>(1e-9));  // where nothing fires the answer fades to zero
        for (int o = 0; o < outputs; ++o) y[o] = y[o] * over;
    }

  private:
    AidModel kind = AidModel::gaussian;
    std::vector<int> counts;
    int outputs = 0, rules = 1;
    std::vector<std::vector<T>> memberships;
    std::vector<T> consequents;

    int widths() const {
        int sum = 0;
        for (int n : counts) sum += n;
        return sum;
    }

    T grade(int input, int k, T u) const {
        const T *p = &memberships[input][k * (kind == AidModel::gaussian ? 2 : 3)], zero = splat<T>(0.0), one = splat<T>(1.0);
        if (kind == AidModel::gaussian) {
            const T d = (u - p[0]) / p[1];
            return exponential<T>(-0.5 * d * d);
        }
        if (kind == AidModel::bell) {  // |d|^2b in logarithms; 1 at the centre itself
            const T d = larger<T>(magnitude((u - p[0]) / p[1]), splat<T>(1e-150));
            return 1.0 / (1.0 + exponential<T>(2.0 * p[2] * logarithm<T>(d)));
        }
        T rising = (u - p[0]) / (p[1] - p[0]), falling = (p[2] - u) / (p[2] - p[1]);
        if (k == 0) rising = select<T>(u <= p[1], one, rising);
        if (k == counts[input] - 1) falling = select<T>(u >= p[1], one, falling);
        return larger<T>(smaller<T>(smaller<T>(rising, falling), one), zero);
    }
};

// An estimate lies within the measurement's noise of it, however much the prediction errs: so many sds at most is the unit of a correction.
inline constexpr double aid_most = 2.0;

template <class T> class Aid {
  public:
    explicit Aid(const Composition<T> &composition);
    bool active() const { return d.kind != AidInputs::none; }
    // Of each reported component, after a scan: what is added to it; then the factors of their sds.
    std::vector<T> correction;
    // The estimate before it, where the correction was told from it; else empty.
    std::vector<T> combined;

    void operator()(Step<T> &step, TrackState<T> &s, const Scan<T> &scan, const Outcome<T> &o);
    // Of what is predicted for a time; empty where there is none.
    std::vector<T> at(const TrackState<T> &s, T time) const {
        if (d.kind != AidInputs::plane) return {};
        std::vector<T> out(2 * c.reported.n);
        plane.carried(s.memory.data() + own(s), time, out.data());
        return out;
    }

  private:
    const Composition<T> &c;
    const AidDeclaration &d;
    Combine<T> combine;
    std::vector<T> numbers;  // low, high, centre, scale of each input; scale of each output; how far the answer fades, in widths; factors of sds
    Network<T> network;
    Anfis<T> anfis;
    PlaneCorrector<T> plane;

    std::size_t own(const TrackState<T> &s) const { return s.memory.size() - std::size_t(d.memory(c.reported.axes)); }

    // Of the newest innovation, the newest two, four, ..., each over the root of how many they are.
    void sums(const T *innovations, T *u) const {
        T sum = splat<T>(0.0);
        for (int i = 0, k = 0; i < d.inputs; ++i) {
            for (; k < 1 << i; ++k) sum = sum + innovations[k];
            u[i] = sum * (1.0 / std::sqrt(double(1 << i)));
        }
    }

    // The model's answer; returns how far it is believed.
    T answer(T *u, T *y) const {
        const T zero = splat<T>(0.0);
        T outside = zero;
        for (int k = 0; k < d.inputs; ++k) {
            const T *range = &numbers[4 * k];
            outside = larger<T>(outside, larger<T>(range[0] - u[k], u[k] - range[1]) / (range[1] - range[0]));
            u[k] = (larger<T>(smaller<T>(u[k], range[1]), range[0]) - range[2]) / range[3];
        }
        const T *scale = &numbers[4 * d.inputs], share = larger<T>(zero, 1.0 - outside / scale[d.outputs]);
        if (d.model == AidModel::network) network(u, y);
        else anfis(u, y);
        for (int k = 0; k < d.outputs; ++k) y[k] = share * scale[k] * y[k];
        return share;
    }
};

template <class T>
Aid<T>::Aid(const Composition<T> &composition)
    : c(composition), d(c.declared.aid), combine(composition), numbers(Composition<T>::numbers(d.numbers)) {
    if (!active()) return;
    correction.assign(2 * c.reported.n, splat<T>(0.0));
    if (d.kind == AidInputs::plane) {
        plane = PlaneCorrector<T>(d, c.reported);
        combined.resize(c.reported.n);
        return;
    }
    const int used = 4 * d.inputs + d.outputs + 1 + aid_factors;
    if (d.model == AidModel::network) {
        network.sizes = d.sizes;
        network.numbers.assign(numbers.begin() + used, numbers.end());
    } else {
        anfis = Anfis<T>(d.model, d.sizes, d.outputs, &numbers[used]);
    }
}

template <class T> void Aid<T>::operator()(Step<T> &step, TrackState<T> &s, const Scan<T> &scan, const Outcome<T> &o) {
    const int n = c.reported.n, axes = c.reported.axes, block = c.reported.block;
    T before[largest_state], P[packed_size(largest_state)], after[largest_state];
    const Fix<T> fix = step.position_of(scan);
    const Mask<T> taken = o.scored & inverse(o.gated) & fix.position, started = o.initialised | o.restarted;
    T *past = s.memory.data() + own(s);
    const T *arena = s.arena.data(), *probability = s.probability.data(), *prior = step.ahead.prior.data();
    if (d.kind == AidInputs::plane) {
        combine(arena, probability, combined.data(), nullptr);
        const PlaneMoments<T> predicted(c, step.ahead.predicted.data(), prior, 0), position(c, arena, probability, 0), velocity(c, arena, probability, 1);
        const Seen<T> seen{predicted, position, velocity, combined.data(), probability, prior, scan.time, &fix, taken, started};
        plane(seen, past, correction.data());
        return;
    }
    step.ahead.merge_pairs();
    combine(step.ahead.predicted.data(), prior, before, P);
    combine(arena, probability, after, nullptr);
    const T one = splat<T>(1.0), *factor = &numbers[4 * d.inputs + d.outputs + 1];
    for (int i = 0; i < n; ++i) correction[i] = splat<T>(0.0), correction[n + i] = one;
    for (int a = 0; a < axes; ++a) {
        const int p = a * block;
        T u[largest_layer], y[3];
        const T R = fix.P[packed(a, a)], S = P[packed(p, p)] + R, root = square_root(larger<T>(S, splat<T>(1e-300)));
        if (d.kind == AidInputs::residuals) {
            u[0] = fix.p[a] - after[p], u[1] = before[p] - after[p];
        } else {
            const int length = d.history();
            T *mine = past + a * length;
            for (int k = length - 1; k > 0; --k) mine[k] = select<T>(taken, mine[k - 1], mine[k]);
            mine[0] = select<T>(taken, (fix.p[a] - before[p]) / root, mine[0]);
            if (d.kind == AidInputs::sums) sums(mine, u);
            else
                for (int k = 0; k < length; ++k) u[k] = mine[k];
        }
        const T share = answer(u, y), most = smaller<T>(root, aid_most * square_root(R));
        for (int k = 0; k < d.outputs && k < block; ++k) {
            const T unit = d.kind == AidInputs::residuals ? splat<T>(1.0)
                                                          : most * square_root(P[packed(p + k, p + k)] / larger<T>(P[packed(p, p)], splat<T>(1e-300)));
            correction[p + k] = select<T>(taken, unit * y[k], splat<T>(0.0));
        }
        for (int k = 0; k < aid_factors && k < block; ++k) correction[n + p + k] = select<T>(taken, one + share * (factor[k] - one), one);
    }
}

// What goes out: x (n) and, where wanted, P (packed), by a correction as Aid has it; an empty one changes nothing.
template <class T, class C> void corrected(const std::vector<C> &correction, T *x, T *P) {
    const int n = int(correction.size() / 2);
    for (int i = 0; i < n; ++i) x[i] = x[i] + correction[i];
    for (int i = 0; P && i < n; ++i)
        for (int j = 0; j <= i; ++j) P[packed(i, j)] = P[packed(i, j)] * (correction[n + i] * correction[n + j]);
}

}  // namespace jink::inline JINK_LEVEL
