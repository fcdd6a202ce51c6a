// Adapt: the process noise of a mode, set from its own prediction and from the measurement it is about to be updated with.
//
// A mode that adapts is predicted without noise; then each axis gets a variance, and Q = sum over axes of variance times the
// motion's Q for unit variance is added. Its carry is what it remembers from scan to scan.
//   current_statistical  s2 = (4 - pi)/pi (a_max -+ a)^2, a the predicted acceleration. Zhou & Kumar, J. Guidance 7(5), 1984.
//   fuzzy_limits         the same with a_max = a_th min(1, exp(-k (1 - |a|/a_th))). Wang, Qin, Yang & Yang, Defence Technology 2010.
//   fuzzy_rules          Sugeno rules over the residual and its change. Lee, Joo & Park, Trans. KIEE 52D-1-3, 2003.
//   network              a perceptron over the noise last used and how likely the measurement is with it. Choi, Samal & Ahn, 2001.
#pragma once

#include "models/fuzzy.hpp"
#include "models/motion.hpp"
#include "models/network.hpp"
#include "models/sensor.hpp"

namespace jink::inline JINK_LEVEL {

enum class Adapt { none, current_statistical, fuzzy_limits, fuzzy_rules, network };

struct AdaptDeclaration {
    Adapt kind = Adapt::none;
    std::vector<int> sizes;       // of the network's layers; its inputs and output in logarithms if `logarithmic`
    bool logarithmic = false;
    std::vector<double> numbers;  // as Adaptation reads them
};

template <class T> class Adaptation {
  public:
    Adapt kind = Adapt::none;

    Adaptation() = default;
    Adaptation(const AdaptDeclaration &d, const std::vector<T> &values) : kind(d.kind), logarithmic(d.logarithmic), numbers(values) {
        if (kind != Adapt::network) return;
        network.sizes = d.sizes;
        const int scales = 2 * d.sizes.front() + 4;  // of each input an offset and a scale; offset, scale, low, high of the output
        network.numbers.assign(values.begin() + scales, values.end());
    }

    bool active() const { return kind != Adapt::none; }
    bool needs_residual() const { return kind == Adapt::fuzzy_rules || kind == Adapt::network; }
    // Per axis the last residual and the last variance; and whether there was a last residual.
    int carry_size(int axes) const { return needs_residual() ? 2 * axes + 1 : 0; }

    // Nothing has been seen yet: the variances are the declared ones.
    void forget(int axes, const T *declared, T *carry, Mask<T> which) const {
        if (!needs_residual()) return;
        for (int a = 0; a < axes; ++a) {
            carry[a] = select<T>(which, splat<T>(0.0), carry[a]);
            carry[axes + a] = select<T>(which, declared[a], carry[axes + a]);
        }
        carry[2 * axes] = select<T>(which, splat<T>(0.0), carry[2 * axes]);
    }

    // The variance of each axis. `in` is the mode predicted without noise, `unit` the variance of a position after this step per
    // unit of each axis' variance; without a measured position the last variance is kept and the change of residual starts anew.
    void operator()(const T *in, int block, int axes, int n, const T *unit, const Fix<T> *fix, T *carry, T *variance) const {
        switch (kind) {
            case Adapt::current_statistical:
            case Adapt::fuzzy_limits:
                for (int a = 0; a < axes; ++a) variance[a] = about_acceleration(in[a * block + 2]);
                return;
            case Adapt::fuzzy_rules: return by_rules(in, block, axes, fix, carry, variance);
            case Adapt::network: return by_network(in, block, axes, n, unit, fix, carry, variance);
            default: return;
        }
    }

  private:
    bool logarithmic = false;
    std::vector<T> numbers;
    Network<T> network;

    // numbers: a_max, a_min (both positive), least margin as a share of the limit; with fuzzy limits a_th, k above, k below, least margin.
    T about_acceleration(T a) const {
        constexpr double pi = 3.14159265358979323846;
        const T zero = splat<T>(0.0), one = splat<T>(1.0), size = magnitude(a);
        const Mask<T> up = inverse(a < zero);
        T limit = select<T>(up, numbers[0], numbers[1]), share = numbers[2];
        if (kind == Adapt::fuzzy_limits) {
            const T k = select<T>(up, numbers[1], numbers[2]);
            limit = numbers[0] * smaller<T>(one, exponential<T>(-(k * (1.0 - size / numbers[0]))));
            share = numbers[3];
        }
        const T margin = larger<T>(limit - size, share * limit);
        return (4.0 - pi) / pi * margin * margin;
    }

    void by_rules(const T *in, int block, int axes, const Fix<T> *fix, T *carry, T *variance) const {
        const T zero = splat<T>(0.0), one = splat<T>(1.0);
        const Mask<T> seen = fix ? fix->position : splat_mask<T>(false), again = carry[2 * axes] > zero;
        for (int a = 0; a < axes; ++a) {
            const T r = fix ? select<T>(seen, fix->p[a] - in[a * block], zero) : zero;
            const T change = select<T>(again, r - carry[a], zero);
            const T said = fix ? fuzzy_variance<T>(int(numbers.size()) / fuzzy_fields, numbers.data(), r, change) : zero;
            variance[a] = select<T>(seen, said, carry[axes + a]);
            carry[a] = r, carry[axes + a] = variance[a];
        }
        carry[2 * axes] = select<T>(seen, one, zero);
    }

    // Inputs: the variance last used, and of each axis the measurement's likelihood with it, N(r; 0, S); or log variance and log(r^2/S + 0.01).
    void by_network(const T *in, int block, int axes, int n, const T *unit, const Fix<T> *fix, T *carry, T *variance) const {
        const T zero = splat<T>(0.0);
        const Mask<T> seen = fix ? fix->position : splat_mask<T>(false);
        const int inputs = network.inputs();
        T x[8], y[4];
        const T last = carry[axes];
        x[0] = logarithmic ? logarithm<T>(last) : last;
        for (int a = 0; a < axes; ++a) {
            const T r = fix ? select<T>(seen, fix->p[a] - in[a * block], zero) : zero;
            const T S = in[n + packed(a * block, a * block)] + unit[a] * last + (fix ? fix->P[packed(a, a)] : splat<T>(1.0));
            const T nis = r * r * reciprocal(S);
            x[1 + a] = logarithmic ? logarithm<T>(nis + 0.01) : exponential<T>(-0.5 * nis) * (0.39894228040143267794 * reciprocal_root(S));
        }
        for (int k = 0; k < inputs; ++k) x[k] = (x[k] - numbers[2 * k]) / numbers[2 * k + 1];
        network(x, y);
        const T *out = numbers.data() + 2 * inputs, low = out[2], high = out[3];
        T q = out[0] + out[1] * y[0];
        if (logarithmic) {
            const T from = logarithm<T>(low), share = reciprocal(1.0 + exponential<T>(-q));
            q = exponential<T>(from + (logarithm<T>(high) - from) * share);
        } else {
            q = larger<T>(smaller<T>(q, high), low);
        }
        for (int a = 0; a < axes; ++a) carry[axes + a] = variance[a] = select<T>(seen, q, last);
    }
};

}  // namespace jink::inline JINK_LEVEL
