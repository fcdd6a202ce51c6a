// The start of a track: from one measured position, or by differencing two.
#pragma once

#include "scan/track.hpp"

namespace jink::inline JINK_LEVEL {

// From one position: no velocity unless it was measured, and each further component from its prior.
template <class T> void start(const Composition<T> &c, TrackState<T> &s, const Fix<T> &fix, Mask<T> fresh) {
    const T zero = splat<T>(0.0), spread = c.velocity_variance;
    for (int j = 0; j < int(c.modes.size()); ++j) {
        const Mode<T> &mode = c.modes[j];
        const int axes = mode.shape.axes, block = mode.shape.block;
        T *x = &s.arena[mode.place], *P = x + mode.shape.n;
        for (int i = 0; i < mode.shape.n; ++i) {
            x[i] = select<T>(fresh, zero, x[i]);
            for (int k = 0; k <= i; ++k)
                P[packed(i, k)] = select<T>(fresh, i == k ? mode.prior_variance[i] : zero, P[packed(i, k)]);
        }
        for (int a = 0; a < axes; ++a) {
            const int p = a * block, v = p + 1;
            x[p] = select<T>(fresh, fix.p[a], x[p]);
            x[v] = select<T>(fresh & fix.velocity, fix.v[a], x[v]);
            for (int b = 0; b <= a; ++b) {
                T &Pp = P[packed(p, b * block)], &Pv = P[packed(v, b * block + 1)];
                Pp = select<T>(fresh, fix.P[packed(a, b)], Pp);
                Pv = select<T>(fresh, select<T>(fix.velocity, fix.V[packed(a, b)], a == b ? spread : zero), Pv);
            }
        }
        if (mode.adapt.remembers()) mode.adapt.forget(axes, mode.declared.data(), &s.carry[mode.carry], fresh);
        if (j < c.count) s.probability[j] = select<T>(fresh, c.initial_probability[j], s.probability[j]);
    }
    for (int j = 0; j < int(s.next.size()); ++j)
        s.alive[j] = s.next[j] = select<T>(fresh, splat<T>(c.declared.propose.start[j]), s.next[j]);
    for (auto &value : s.memory) value = select<T>(fresh, zero, value);
    for (int a = 0; a < 3; ++a) s.first[a] = select<T>(fresh, fix.p[a], s.first[a]);
    for (int k = 0; k < 6; ++k) s.first_P[k] = select<T>(fresh, fix.P[k], s.first_P[k]);
    s.first_time = select<T>(fresh, s.time, s.first_time);
}

// A second position to which the target would have had to go at more than `farthest_sds` standard deviations of its speed
// contradicts the first. The track then begins anew from the second. After `contradictions` in a row the target is that fast.
constexpr double farthest_sds = 5.0, contradictions = 2.0;

template <class T> Mask<T> contradicted(const Composition<T> &c, const TrackState<T> &s, const Fix<T> &fix, Mask<T> second) {
    const T step = s.time - s.first_time;
    T squares = splat<T>(0.0);
    for (int a = 0; a < c.modes[0].shape.axes; ++a) {
        const T moved = fix.p[a] - s.first[a];
        const T variance = c.velocity_variance * step * step + fix.P[packed(a, a)] + s.first_P[packed(a, a)];
        squares = squares + moved * moved / variance;
    }
    return second & (step > splat<T>(0.0)) & (squares > splat<T>(farthest_sds * farthest_sds)) & (s.rejections < splat<T>(contradictions));
}

// A velocity is that of a target of such a speed: conditioned on N(0, velocity_variance) per axis.
template <class T> void slow_down(const Composition<T> &c, TrackState<T> &s, Mask<T> which) {
    for (const Mode<T> &mode : c.modes) {
        const int n = mode.shape.n;
        T *x = &s.arena[mode.place], *P = x + n;
        for (int a = 0; a < mode.shape.axes; ++a) {
            const int v = a * mode.shape.block + 1;
            T column[largest_state];
            for (int i = 0; i < n; ++i) column[i] = P[i < v ? packed(v, i) : packed(i, v)];
            const T over = 1.0 / (column[v] + c.velocity_variance), kept = c.velocity_variance * over, speed = x[v];
            for (int i = 0; i < n; ++i) {
                const T gain = column[i] * over;
                x[i] = select<T>(which, i == v ? kept * speed : x[i] - gain * speed, x[i]);
                for (int k = 0; k <= i; ++k) {
                    T &value = P[packed(i, k)];
                    const T rounding = i == k ? rounding_share(n) * value : splat<T>(0.0);
                    value = select<T>(which, i == v || k == v ? kept * value : value - gain * column[k] + rounding, value);
                }
            }
        }
    }
}

// Two-point differencing: v = (z2 - z1) / T, with acceleration of prior variance a0^2 over the step. Where that is no velocity of
// anything, because the step is too short for the distance, the track waits for another point.
template <class T> void complete(const Composition<T> &c, TrackState<T> &s, const Fix<T> &fix, Mask<T> second) {
    const T step = s.time - s.first_time;
    Mask<T> now = second & (step > splat<T>(0.0));
    const T over = 1.0 / select<T>(now, step, splat<T>(1.0));
    for (const Mode<T> &mode : c.modes)
        for (int a = 0; a < mode.shape.axes; ++a)
            now = now & (magnitude(fix.p[a] - s.first[a]) * over <= splat<T>(farthest)) &
                  ((fix.P[packed(a, a)] + s.first_P[packed(a, a)]) * over * over <= splat<T>(farthest * farthest));
    T kept_first[3], kept_P[6], kept_time = s.first_time;
    for (int a = 0; a < 3; ++a) kept_first[a] = s.first[a];
    for (int k = 0; k < 6; ++k) kept_P[k] = s.first_P[k];
    start(c, s, fix, now);
    s.first_time = kept_time;
    for (const Mode<T> &mode : c.modes) {
        const int block = mode.shape.block;
        T *x = &s.arena[mode.place], *P = x + mode.shape.n;
        const auto put = [&](int r, int k, T value) { P[packed(r, k)] = select<T>(now, value, P[packed(r, k)]); };
        for (int a = 0; a < mode.shape.axes; ++a) {
            const int p = a * block, v = p + 1;
            x[v] = select<T>(now, (fix.p[a] - kept_first[a]) * over, x[v]);
            for (int b = 0; b < mode.shape.axes; ++b) {
                const T R = fix.P[packed(a, b)];
                put(v, b * block, R * over);
                if (b <= a) put(v, b * block + 1, (R + kept_P[packed(a, b)]) * over * over);
            }
            if (block != 3) continue;
            const T spread = mode.prior_variance[p + 2];
            put(v, v, P[packed(v, v)] + 0.25 * step * step * spread);
            put(p + 2, v, 0.5 * step * spread);
        }
    }
    if (c.declared.start == Start::bounded_two_point) slow_down(c, s, now & inverse(s.rejections >= splat<T>(contradictions)));
    s.running = s.running | now;
}

}  // namespace jink::inline JINK_LEVEL
