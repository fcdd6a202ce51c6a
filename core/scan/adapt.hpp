// Adapt: the process noise of a mode, set from its own prediction and from the measurement it is about to be updated with.
//
// A mode that adapts is predicted without noise; then each axis gets a variance, and Q = sum over axes of variance times the
// motion's Q for unit variance is added. Its carry is what it remembers from scan to scan.
//   current_statistical, fuzzy_limits, straight_limits: what fixed or fuzzy limits of the acceleration leave (acceleration_limits.hpp).
//   fuzzy_rules          Sugeno rules over the residual and its change. Lee, Joo & Park, Trans. KIEE 52D-1-3, 2003. Two tables of them
//                        hold along the velocity and across it: r along e = v/sqrt(|v|^2 + tr P_v), and |r - (r e) e|, which has no sign,
//                        so that left is as right; Q of the axes is D = q_across I + (q_along - q_across) e e' times Q for unit variance.
//   network              a perceptron over the noise last used and how likely the measurement is with it. Choi, Samal & Ahn, 2001.
#pragma once

#include "models/fuzzy.hpp"
#include "models/motion.hpp"
#include "models/network.hpp"
#include "scan/acceleration_limits.hpp"

namespace jink::inline JINK_LEVEL {

enum class Adapt { none, current_statistical, fuzzy_limits, fuzzy_rules, network, straight_limits };

struct AdaptDeclaration {
    Adapt kind = Adapt::none;
    std::vector<int> sizes;       // of the network's layers; or how many rules hold along the velocity and how many across it
    bool logarithmic = false;     // the network's inputs and output
    std::vector<double> numbers;  // as Adaptation reads them
};

template <class T> class Adaptation {
  public:
    Adapt kind = Adapt::none;

    Adaptation() = default;
    Adaptation(const AdaptDeclaration &d, const std::vector<T> &values) : kind(d.kind), logarithmic(d.logarithmic), numbers(values) {
        if (kind == Adapt::fuzzy_rules && d.sizes.size() == 2) rules_along = d.sizes[0];
        if (kind != Adapt::network) return;
        network.sizes = d.sizes;
        const int scales = 2 * d.sizes.front() + 4;  // of each input an offset and a scale; offset, scale, low, high of the output
        network.numbers.assign(values.begin() + scales, values.end());
    }

    bool active() const { return kind != Adapt::none; }
    bool remembers() const { return kind == Adapt::fuzzy_rules || kind == Adapt::network; }
    bool needs_residual() const { return remembers() || (limited() && AccelerationLimits<T>::widens(numbers)); }
    // Per axis the last residual; per axis, or along and across, the last variance; and whether there was a last residual.
    int carry_size(int axes) const { return remembers() ? axes + variances(axes) + 1 : 0; }

    // Nothing has been seen yet: the variances are the declared ones.
    void forget(int axes, const T *declared, T *carry, Mask<T> which) const {
        if (!remembers()) return;
        const int seen = axes + variances(axes);
        for (int a = 0; a < axes; ++a) carry[a] = select<T>(which, splat<T>(0.0), carry[a]);
        for (int k = axes; k < seen; ++k) carry[k] = select<T>(which, declared[rules_along ? 0 : k - axes], carry[k]);
        carry[seen] = select<T>(which, splat<T>(0.0), carry[seen]);
    }

    // The variance of each axis, and of each pair of axes the covariance over the lesser axis' variance, where there is one. `in` is
    // the mode predicted without noise, `unit` the variance of a position after this step per unit of each axis' variance; without a
    // measured position the last variance is kept and the change of residual starts anew.
    void operator()(const T *in, int block, int axes, int n, const T *unit, const Fix<T> *fix, T *carry, T *variance, T *ratio) const {
        if (limited()) return AccelerationLimits<T>(membership(), numbers)({in, in + n, block, axes, unit, fix}, variance, ratio);
        if (rules_along) return by_rules_along_track(in, block, axes, n, fix, carry, variance, ratio);
        if (kind == Adapt::fuzzy_rules) return by_rules(in, block, axes, fix, carry, variance);
        if (kind == Adapt::network) by_network(in, block, axes, n, unit, fix, carry, variance);
    }

  private:
    bool logarithmic = false;
    int rules_along = 0;  // of two tables the rules of the first; 0: one table holds for every axis
    std::vector<T> numbers;
    Network<T> network;

    int variances(int axes) const { return rules_along ? 2 : axes; }

    bool limited() const { return kind == Adapt::current_statistical || kind == Adapt::fuzzy_limits || kind == Adapt::straight_limits; }
    Membership membership() const {
        return kind == Adapt::fuzzy_limits ? Membership::exponential : kind == Adapt::straight_limits ? Membership::straight : Membership::fixed;
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

    void by_rules_along_track(const T *in, int block, int axes, int n, const Fix<T> *fix, T *carry, T *variance, T *ratio) const {
        const T zero = splat<T>(0.0), one = splat<T>(1.0);
        const Mask<T> seen = fix ? fix->position : splat_mask<T>(false), again = carry[axes + 2] > zero;
        T e[3], r[3], change[3], *q = carry + axes;
        known_direction<T>(in, in + n, block, axes, e);
        for (int a = 0; a < axes; ++a) {
            r[a] = fix ? select<T>(seen, fix->p[a] - in[a * block], zero) : zero;
            change[a] = select<T>(again, r[a] - carry[a], zero);
            carry[a] = r[a];
        }
        if (fix) {
            const AlongAcross<T> at(axes, e, r, change);
            const T *others = numbers.data() + rules_along * fuzzy_fields;
            const int rest = int(numbers.size()) / fuzzy_fields - rules_along;
            q[0] = select<T>(seen, fuzzy_variance<T>(rules_along, numbers.data(), at.along, at.change_along), q[0]);
            q[1] = select<T>(seen, fuzzy_variance<T>(rest, others, at.across, at.change_across), q[1]);
        }
        carry[axes + 2] = select<T>(seen, one, zero);
        along_and_across<T>(axes, e, q[1], q[0] - q[1], variance, ratio);
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
