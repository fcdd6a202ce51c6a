// Limits of the acceleration, and the variance that they leave about the acceleration there is.
//   sigma^2 = (4 - pi)/pi (limit - |a|)^2, a the predicted acceleration. Zhou & Kumar, J. Guidance 7(5), 1984.
//   limit(a): fixed; or a_th min(1, exp(-k (1 - |a|/a_th))); or a straight line between the same ends, a_th min(1, e^-k + (1 - e^-k) |a|/a_th).
//   Wang, Qin, Yang & Yang, Defence Technology 2010.
// Two directions, along the velocity and across it, give D = across I + s (along - across) u u', u the velocity's direction,
// s = |v|^2 / (|v|^2 + tr P_v), so that noise is the same in all directions while the direction is unknown.
#pragma once

#include "models/sensor.hpp"
#include "scan/along_track.hpp"

namespace jink::inline JINK_LEVEL {

enum class Membership { fixed, exponential, straight };

// A mode that is predicted without noise, and the position that it is about to be updated with.
template <class T> struct Ahead {
    const T *x, *P;
    int block, axes;
    const T *unit;     // variance of a position after this step per unit of each axis' variance
    const Fix<T> *fix; // or null
    T velocity(int a) const { return x[a * block + 1]; }
    T acceleration(int a) const { return x[a * block + 2]; }
    T residual(int a) const { return fix->p[a] - x[a * block]; }
    // Of the residual, before the step's noise.
    T covariance(int a, int b) const { return P[packed(a * block, b * block)] + fix->P[packed(a, b)]; }
};

// numbers: of each direction the thresholds above and below zero (both positive) and their exponents; the least margin as a share of
// the limit; and, if limits widen, the NIS from which they are as wide as they get, and how many thresholds wide that is.
template <class T> class AccelerationLimits {
  public:
    AccelerationLimits(Membership membership_, const std::vector<T> &numbers_)
        : membership(membership_), n(numbers_), turned(n.size() >= 2 * per_direction + 1), widened(n.size() % per_direction == 3) {}

    // Variance of each axis, and of each pair of axes the covariance over the variance of the lesser axis.
    void operator()(const Ahead<T> &at, T *variance, T *ratio) const {
        if (turned) return along_track(at, variance, ratio);
        for (int a = 0; a < at.axes; ++a) {
            variance[a] = quiet(n.data(), at.acceleration(a));
            if (!widened || !at.fix) continue;
            const T r = at.residual(a), S = at.covariance(a, a) + at.unit[a] * variance[a];
            variance[a] = wide(n.data(), at.acceleration(a), variance[a], r * r * reciprocal(S), at.fix->position);
        }
    }

    static bool widens(const std::vector<T> &numbers) { return numbers.size() % per_direction == 3; }

  private:
    static constexpr int per_direction = 4;
    static constexpr double pi = 3.14159265358979323846, rayleigh = (4.0 - pi) / pi, nothing = 1e-300;
    Membership membership;
    const std::vector<T> &n;
    bool turned, widened;

    const T &share() const { return n[turned ? 2 * per_direction : per_direction]; }
    T most(const T *of, T a) const { return select<T>(a < splat<T>(0.0), of[1], of[0]); }

    T limit(const T *of, T a) const {
        const T top = most(of, a), one = splat<T>(1.0);
        if (membership == Membership::fixed) return top;
        const T k = select<T>(a < splat<T>(0.0), of[3], of[2]), part = magnitude(a) / top;
        if (membership == Membership::exponential) return top * smaller<T>(one, exponential<T>(-(k * (1.0 - part))));
        const T rest = exponential<T>(-k);
        return top * smaller<T>(one, rest + (1.0 - rest) * part);
    }

    T quiet(const T *of, T a) const {
        const T largest = limit(of, a), margin = larger<T>(largest - magnitude(a), share() * largest);
        return rayleigh * margin * margin;
    }

    // From NIS 1, its mean, on: towards the margin from -times a_th to a.
    T wide(const T *of, T a, T least, T nis, Mask<T> seen) const {
        const T *by = &share() + 1, zero = splat<T>(0.0);
        const T margin = by[1] * most(of, a) + magnitude(a), part = smaller<T>(larger<T>((nis - 1.0) / (by[0] - 1.0), zero), splat<T>(1.0));
        return least + select<T>(seen, part * larger<T>(rayleigh * margin * margin - least, zero), zero);
    }

    void along_track(const Ahead<T> &at, T *variance, T *ratio) const {
        const int axes = at.axes;
        const T zero = splat<T>(0.0);
        T u[3], speed = zero, spread = zero, along = zero, left = splat<T>(nothing);
        for (int a = 0; a < axes; ++a) {
            const T v = at.velocity(a);
            speed = speed + v * v, spread = spread + at.P[packed(a * at.block + 1, a * at.block + 1)];
        }
        const T over = reciprocal_root(larger<T>(speed, splat<T>(nothing)));
        for (int a = 0; a < axes; ++a) {
            u[a] = at.velocity(a) * over;
            along = along + at.acceleration(a) * u[a];
        }
        for (int a = 0; a < axes; ++a) {
            const T rest = at.acceleration(a) - along * u[a];
            left = left + rest * rest;
        }
        const T across = square_root(left);
        const T known = axes == 1 ? splat<T>(1.0) : speed * reciprocal(speed + spread + nothing);
        T first = quiet(n.data(), along), second = quiet(n.data() + per_direction, across);
        if (widened && at.fix) widen(at, u, along, across, first, second);
        if (axes == 1) variance[0] = first;
        else along_and_across(axes, u, second, known * (first - second), variance, ratio);
    }

    // NIS along the velocity, and the mean of those across it.
    void widen(const Ahead<T> &at, const T *u, T along, T across, T &first, T &second) const {
        const T zero = splat<T>(0.0);
        T r = zero, squares = zero, S = zero, trace = zero;
        for (int a = 0; a < at.axes; ++a) {
            const T residual = at.residual(a);
            r = r + residual * u[a], squares = squares + residual * residual, trace = trace + at.covariance(a, a);
            for (int b = 0; b < at.axes; ++b) S = S + u[a] * u[b] * at.covariance(a, b);
        }
        const T own = r * r * reciprocal(S + at.unit[0] * first);
        const T others = (squares - r * r) * reciprocal(trace - S + (at.axes - 1.0) * at.unit[0] * second + nothing);
        first = wide(n.data(), along, first, own, at.fix->position);
        second = wide(n.data() + per_direction, across, second, others, at.fix->position);
    }
};

}  // namespace jink::inline JINK_LEVEL
