// The estimate that goes out: the modes' estimates in the reported components, matched in their first two moments.
//
// A component a mode lacks is what its kinematics say: in a turn the acceleration is w x v, with an acceleration the turn
// rate is (v x a) / |v|^2; a constant velocity has neither. Their covariances follow from the Jacobian of that.
#pragma once

#include "scan/composition.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class Combine {
  public:
    explicit Combine(const Composition<T> &composition);

    // x (n) and, unless null, packed P of the mixture of `arena`'s modes with these probabilities.
    void operator()(const T *arena, const T *probability, T *x, T *P);

  private:
    const Composition<T> &c;
    int n;
    std::vector<T> means, covariances;
    std::vector<const T *> mean, covariance;

    void expand(const Mode<T> &mode, const T *from, T *x, T *P) const {
        const StateShape &own = mode.shape, &all = c.reported;
        const bool turning = own.turn || mode.motion.kind == MotionKind::known_turn;
        if (!(all.block == 3 && own.block == 2 && turning) && !(all.turn && !own.turn && (own.block == 3 || turning)))
            return copy(mode, from, x, P);
        T J[largest_state * largest_state];  // of the reported components by the mode's own
        for (int k = 0; P && k < all.n * own.n; ++k) J[k] = splat<T>(0.0);
        for (int i = 0; i < all.n; ++i) {
            const int at = place_of(all, i, own);
            x[i] = at >= 0 ? from[at] : splat<T>(0.0);
            if (P && at >= 0) J[i * own.n + at] = splat<T>(1.0);
        }
        if (all.block == 3 && own.block == 2) turning_acceleration(mode, from, x, J);
        if (all.turn && !own.turn) turn_rate(mode, from, x + all.n - 1, J + (all.n - 1) * own.n);
        if (!P) return;
        for (int r = 0; r < all.n; ++r) {
            T row[largest_state];
            for (int k = 0; k < own.n; ++k) {
                row[k] = splat<T>(0.0);
                for (int l = 0; l < own.n; ++l) row[k] = row[k] + J[r * own.n + l] * from[own.n + packed(l, k)];
            }
            for (int q = 0; q <= r; ++q) {
                T sum = splat<T>(0.0);
                for (int k = 0; k < own.n; ++k) sum = sum + row[k] * J[q * own.n + k];
                if (r == q) {  // see rounding_share: of what was summed, before it cancelled
                    T spread = splat<T>(0.0);
                    for (int k = 0; k < own.n; ++k) spread = spread + J[r * own.n + k] * J[r * own.n + k] * from[own.n + packed(k, k)];
                    sum = sum + rounding_share(all.n) * spread;
                }
                P[packed(r, q)] = sum;
            }
        }
    }

    // A mode that says nothing of the components it lacks: they are zero.
    void copy(const Mode<T> &mode, const T *from, T *x, T *P) const {
        int at[largest_state];
        const T zero = splat<T>(0.0), *covariance_of = from + mode.shape.n;
        for (int i = 0; i < n; ++i) at[i] = place_of(c.reported, i, mode.shape), x[i] = at[i] >= 0 ? from[at[i]] : zero;
        for (int r = 0; r < n && P; ++r)
            for (int q = 0; q <= r; ++q)
                P[packed(r, q)] = at[r] >= 0 && at[q] >= 0 ? covariance_of[packed(at[r], at[q])] : zero;
    }

    void turning_acceleration(const Mode<T> &mode, const T *from, T *x, T *J) const {
        const int n_own = mode.shape.n;
        const bool known = mode.motion.kind == MotionKind::known_turn;
        if (!known && !mode.shape.turn) return;
        const T w = known ? mode.parameters[mode.shape.axes] : from[n_own - 1];
        x[2] = -(w * from[3]), x[5] = w * from[1];
        J[2 * n_own + 3] = -w, J[5 * n_own + 1] = w;
        if (!known) J[2 * n_own + n_own - 1] = -from[3], J[5 * n_own + n_own - 1] = from[1];
    }

    void turn_rate(const Mode<T> &mode, const T *from, T *w, T *row) const {
        if (mode.motion.kind == MotionKind::known_turn) *w = mode.parameters[mode.shape.axes];
        if (mode.shape.block != 3 || mode.shape.axes < 2) return;
        const T vx = from[1], ax = from[2], vy = from[4], ay = from[5];
        const T over = 1.0 / larger<T>(vx * vx + vy * vy, splat<T>(1e-6));
        *w = (vx * ay - vy * ax) * over;
        row[1] = (ay - 2.0 * *w * vx) * over, row[4] = -((ax + 2.0 * *w * vy) * over);
        row[2] = -(vy * over), row[5] = vx * over;
    }
};

template <class T> Combine<T>::Combine(const Composition<T> &composition) : c(composition), n(c.reported.n) {
    means.resize(c.count * n);
    covariances.resize(c.count * packed_size(n));
    mean.resize(c.count), covariance.resize(c.count);
}

template <class T> inline void Combine<T>::operator()(const T *arena, const T *probability, T *x, T *P) {
    if (c.count == 1 && !c.derived) {
        const T *from = arena + c.modes[0].place;
        for (int i = 0; i < n; ++i) x[i] = from[i];
        if (P)
            for (int k = 0; k < packed_size(n); ++k) P[k] = from[n + k];
        return;
    }
    const int size = packed_size(n);
    for (int j = 0; j < c.count; ++j) {
        const Mode<T> &mode = c.modes[j];
        const T *from = arena + mode.place;
        if (mode.shape.n == n) {
            mean[j] = from, covariance[j] = from + n;
        } else {
            expand(mode, from, &means[j * n], P ? &covariances[j * size] : nullptr);
            mean[j] = &means[j * n], covariance[j] = &covariances[j * size];
        }
    }
    for (int i = 0; i < n; ++i) {
        T sum = probability[0] * mean[0][i];
        for (int j = 1; j < c.count; ++j) sum = sum + probability[j] * mean[j][i];
        x[i] = sum;
    }
    if (!P) return;
    for (int k = 0; k < size; ++k) P[k] = splat<T>(0.0);
    for (int j = 0; j < c.count; ++j) {
        T d[largest_state];
        for (int i = 0; i < n; ++i) d[i] = mean[j][i] - x[i];
        for (int r = 0; r < n; ++r) {
            const T wd = probability[j] * d[r];
            for (int q = 0; q <= r; ++q)
                P[packed(r, q)] = P[packed(r, q)] + probability[j] * covariance[j][packed(r, q)] + wd * d[q];
        }
    }
}

}  // namespace jink::inline JINK_LEVEL
