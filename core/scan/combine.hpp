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
    std::vector<int> places;  // of each mode's components among the reported ones, -1 where it has none

    // A reported component that the mode's own ones make: its slopes by those that count.
    struct Derived {
        int row, count;
        int by[4];
        T slope[4];
    };

    void expand(int j, const Mode<T> &mode, const T *from, T *x, T *P) const {
        const StateShape &own = mode.shape, &all = c.reported;
        const int *at = &places[j * n];
        for (int i = 0; i < n; ++i) x[i] = at[i] >= 0 ? from[at[i]] : splat<T>(0.0);
        const bool turning = own.turn || mode.motion.kind == MotionKind::known_turn;
        Derived made[3];
        int count = 0;
        if (all.block == 3 && own.block == 2 && turning) count += turning_acceleration(mode, from, x, made);
        if (all.turn && !own.turn && (own.block == 3 || turning)) count += turn_rate(mode, from, x, made + count);
        if (!P) return;
        const T *covariance_of = from + own.n, share = splat<T>(count ? 1.0 + rounding_share(n) : 1.0), zero = splat<T>(0.0);
        for (int r = 0; r < n; ++r)
            for (int q = 0; q <= r; ++q)
                P[packed(r, q)] = at[r] >= 0 && at[q] >= 0 ? covariance_of[packed(at[r], at[q])] : zero;
        for (int r = 0; count && r < n; ++r) P[packed(r, r)] = share * P[packed(r, r)];
        for (int d = 0; d < count; ++d) derive(made, d, own.n, at, covariance_of, P);
    }

    // The covariances of a derived component with those that the mode has and the derived ones before it.
    void derive(const Derived *made, int d, int own, const int *at, const T *covariance_of, T *P) const {
        const Derived &mine = made[d];
        T row[largest_state], spread = splat<T>(0.0);
        for (int k = 0; k < own; ++k) {
            row[k] = splat<T>(0.0);
            for (int l = 0; l < mine.count; ++l) row[k] = row[k] + mine.slope[l] * covariance_of[packed(mine.by[l], k)];
        }
        for (int i = 0; i < n; ++i)
            if (at[i] >= 0) P[packed(mine.row, i)] = row[at[i]];
        for (int e = 0; e <= d; ++e) {
            T sum = splat<T>(0.0);
            for (int l = 0; l < made[e].count; ++l) sum = sum + row[made[e].by[l]] * made[e].slope[l];
            P[packed(mine.row, made[e].row)] = sum;
        }
        // see rounding_share: of what was summed, before it cancelled
        for (int l = 0; l < mine.count; ++l)
            spread = spread + mine.slope[l] * mine.slope[l] * covariance_of[packed(mine.by[l], mine.by[l])];
        T &own_variance = P[packed(mine.row, mine.row)];
        own_variance = own_variance + rounding_share(n) * spread;
    }

    // The accelerations of a turn, in the rows of ax and ay; returns how many.
    int turning_acceleration(const Mode<T> &mode, const T *from, T *x, Derived *made) const {
        const int turn = mode.shape.n - 1;
        const bool known = mode.motion.kind == MotionKind::known_turn;
        const T w = known ? mode.parameters[mode.shape.axes] : from[turn];
        x[2] = -(w * from[3]), x[5] = w * from[1];
        made[0] = {2, known ? 1 : 2, {3, turn}, {-w, -from[3]}};
        made[1] = {5, known ? 1 : 2, {1, turn}, {w, from[1]}};
        return 2;
    }

    // The turn rate that velocity and acceleration make, or that the mode has; returns how many were made.
    int turn_rate(const Mode<T> &mode, const T *from, T *x, Derived *made) const {
        T &w = x[n - 1];
        if (mode.motion.kind == MotionKind::known_turn) w = mode.parameters[mode.shape.axes];
        if (mode.shape.block != 3 || mode.shape.axes < 2) return 0;
        const T vx = from[1], ax = from[2], vy = from[4], ay = from[5];
        const T over = 1.0 / larger<T>(vx * vx + vy * vy, splat<T>(1e-6));
        w = (vx * ay - vy * ax) * over;
        made[0] = {n - 1, 4, {1, 2, 4, 5}, {(ay - 2.0 * w * vx) * over, -(vy * over), -((ax + 2.0 * w * vy) * over), vx * over}};
        return 1;
    }
};

template <class T> Combine<T>::Combine(const Composition<T> &composition) : c(composition), n(c.reported.n) {
    means.resize(c.count * n);
    covariances.resize(c.count * packed_size(n));
    mean.resize(c.count), covariance.resize(c.count);
    for (const Mode<T> &mode : c.modes)
        for (int i = 0; i < n; ++i) places.push_back(place_of(c.reported, i, mode.shape));
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
            expand(j, mode, from, &means[j * n], P ? &covariances[j * size] : nullptr);
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
