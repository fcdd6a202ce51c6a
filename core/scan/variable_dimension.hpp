// The variable-dimension filter's detectors: constant velocity until the innovations say otherwise, then constant acceleration.
//
// Quiet: rho = (1 - 1/W) rho + nis; above its threshold a manoeuvre is taken to have begun W scans ago. The filter with acceleration
// starts there from the measurement and the state before it, a = 2/T^2 (z - p - T v), v + T a, and runs over the measurements since.
// Manoeuvring: when the sum of a' P_aa^-1 a over the last W scans is below its threshold, the target flies straight again.
// Bar-Shalom & Birmiwal, IEEE Trans. AES-18(5), 1982.
#pragma once

#include "scan/propose.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class VariableDimension {
  public:
    explicit VariableDimension(const Composition<T> &composition) : c(composition) {
        if (c.declared.propose.kind != Propose::dimension) return;
        window = int(c.declared.propose.numbers[0]), rise = c.declared.propose.numbers[1], fall = c.declared.propose.numbers[2];
    }
    bool active() const { return window > 0; }

    // Memory: rho, scans quiet, scans manoeuvring; a' P^-1 a of the last W scans; W + 2 entries, newest first, each of them whether
    // there was a position, dt, p, R, and the quiet mode's estimate after the scan (Declaration::history_entry).
    // The scan a track starts with, like the one a manoeuvre ends with, is not yet a quiet one.
    void operator()(TrackState<T> &s, const Fix<T> &fix, T dt, T nis, Mask<T> taken, Mask<T> live, Mask<T> fresh) {
        T *rho = &s.memory[0], *quiet_for = rho + 1, *busy_for = rho + 2, *significance = rho + 3, *entries = significance + window;
        const T zero = splat<T>(0.0), one = splat<T>(1.0);
        const Mask<T> busy = living(s.next[1]) & live, quiet = inverse(living(s.next[1])) & live;
        remember(s, entries, fix, dt, taken & fix.position, live);
        *rho = select<T>(quiet & taken, (1.0 - 1.0 / window) * *rho + nis, *rho);
        *quiet_for = select<T>(quiet & inverse(fresh), *quiet_for + one, *quiet_for);
        *busy_for = select<T>(busy, *busy_for + one, *busy_for);
        const T *onset = entries + window * c.declared.history_entry();
        // a row without a measurement only predicts: what was seen before it is decided on with the next one
        const Mask<T> begins = quiet & taken & (*rho > splat<T>(rise)) & (*quiet_for >= splat<T>(window + 2)) & (onset[0] > zero) & (onset[1] > zero);
        if (any(begins)) begin(s, entries, begins);
        const T now = acceleration_significance(s);
        T sum = now;
        for (int k = window - 1; k > 0; --k) significance[k] = select<T>(busy, significance[k - 1], significance[k]), sum = sum + significance[k];
        significance[0] = select<T>(busy, now, significance[0]);
        const Mask<T> ends = busy & taken & (*busy_for >= splat<T>(window)) & (sum < splat<T>(fall));
        if (any(ends)) end(s, ends);
        const Mask<T> changed = begins | ends;
        *rho = select<T>(changed, zero, *rho), *quiet_for = select<T>(changed, zero, *quiet_for), *busy_for = select<T>(changed, zero, *busy_for);
        const T none = splat<T>(-1.0);
        s.next[0] = select<T>(begins, none, select<T>(ends, zero, s.next[0]));
        s.next[1] = select<T>(begins, one, select<T>(ends, none, s.next[1]));
        for (int j = 0; j < 2; ++j) s.alive[j] = select<T>(live, s.next[j], s.alive[j]);
    }

  private:
    const Composition<T> &c;
    int window = 0;
    double rise = 0.0, fall = 0.0;

    void remember(const TrackState<T> &s, T *entries, const Fix<T> &fix, T dt, Mask<T> measured, Mask<T> live) const {
        const int size = c.declared.history_entry(), A = c.declared.axes();
        for (int k = (window + 2) * size - 1; k >= size; --k) entries[k] = select<T>(live, entries[k - size], entries[k]);
        T now[11 + largest_state + packed_size(largest_state)];
        now[0] = select<T>(measured, splat<T>(1.0), splat<T>(0.0)), now[1] = dt;
        T *end = std::copy_n(fix.p, A, now + 2);
        end = std::copy_n(fix.P, packed_size(A), end);
        std::copy_n(&s.arena[c.modes[0].place], c.modes[0].size(), end);
        for (int k = 0; k < size; ++k) entries[k] = select<T>(live, now[k], entries[k]);
    }

    void begin(TrackState<T> &s, const T *entries, Mask<T> which) const {
        const Mode<T> &busy = c.modes[1];
        const int size = c.declared.history_entry(), A = c.declared.axes(), n = busy.shape.n, quiet_n = c.modes[0].shape.n;
        const T *onset = entries + window * size, *before = onset + size + 2 + A + packed_size(A), *P = before + quiet_n;
        const T *z = onset + 2, *R = z + A, dt = onset[1], over = 1.0 / select<T>(which, dt, splat<T>(1.0));
        T state[largest_state + packed_size(largest_state)], *x = state, *out = x + n;
        for (T &value : state) value = splat<T>(0.0);
        for (int a = 0; a < A; ++a) {
            const int p = 2 * a, v = p + 1, at = 3 * a;
            const T r = R[packed(a, a)], P11 = P[packed(p, p)], P12 = P[packed(v, p)], P22 = P[packed(v, v)];
            x[at + 2] = 2.0 * over * over * (z[a] - before[p] - dt * before[v]);
            x[at] = z[a], x[at + 1] = before[v] + dt * x[at + 2];
            // what is summed with P12, which may cancel
            const T v_spread = 4.0 * over * over * (r + P11) + P22, a_spread = 4.0 * over * over * over * over * (r + P11 + dt * dt * P22);
            out[packed(at, at)] = r * (1.0 + rounding_share(n)), out[packed(at + 1, at)] = 2.0 * r * over, out[packed(at + 2, at)] = 2.0 * r * over * over;
            out[packed(at + 1, at + 1)] = 4.0 * over * over * (r + P11) + P22 + 4.0 * over * P12 + rounding_share(n) * v_spread;
            out[packed(at + 2, at + 1)] = over * (4.0 * over * over * (r + P11) + 2.0 * P22 + 6.0 * over * P12);
            out[packed(at + 2, at + 2)] = 4.0 * over * over * over * over * (r + P11 + 2.0 * dt * P12 + dt * dt * P22) + rounding_share(n) * a_spread;
        }
        SensorSpec spec{SensorKind::position, A, A, Vertical::none, false, false, true, {0.0, 0.0, 0.0}, 0.0};
        for (int e = window - 1; e >= 0; --e) {
            const T *now = entries + e * size;
            T coefficient[largest_coefficients];
            busy.kernels.prepare(busy.motion, now[1], busy.parameters.data(), coefficient);
            busy.kernels.predict(x, coefficient, nullptr, x);
            Measurement<T> m;
            m.full = true;
            for (int a = 0; a < A; ++a) m.z[a] = now[2 + a], m.present[a] = now[0] > splat<T>(0.0);
            for (int k = 0; k < packed_size(A); ++k) m.R[k] = now[2 + A + k];
            Innovation<T> unused;
            busy.update.position(spec, m, x, x, unused, false);
        }
        for (int k = 0; k < busy.size(); ++k) s.arena[busy.place + k] = select<T>(which, state[k], s.arena[busy.place + k]);
        one_hot(s, 1, which);
    }

    void end(TrackState<T> &s, Mask<T> which) const {
        const Mode<T> &quiet = c.modes[0], &busy = c.modes[1];
        const T *from = &s.arena[busy.place];
        T *to = &s.arena[quiet.place];
        const auto in_busy = [](int i) { return i / 2 * 3 + i % 2; };
        for (int i = 0; i < quiet.shape.n; ++i) {
            to[i] = select<T>(which, from[in_busy(i)], to[i]);
            for (int k = 0; k <= i; ++k) {
                T &P = to[quiet.shape.n + packed(i, k)];
                P = select<T>(which, from[busy.shape.n + packed(in_busy(i), in_busy(k))], P);
            }
        }
        one_hot(s, 0, which);
    }

    // The estimate of this scan is already that of the mode that goes on.
    void one_hot(TrackState<T> &s, int mode, Mask<T> which) const {
        for (int j = 0; j < 2; ++j) s.probability[j] = select<T>(which, splat<T>(j == mode ? 1.0 : 0.0), s.probability[j]);
    }

    T acceleration_significance(const TrackState<T> &s) const {
        const Mode<T> &busy = c.modes[1];
        const int A = c.declared.axes();
        const T *x = &s.arena[busy.place], *P = x + busy.shape.n;
        T a[3], Paa[6], L[6], sum = splat<T>(0.0);
        for (int i = 0; i < A; ++i) {
            a[i] = x[3 * i + 2];
            for (int k = 0; k <= i; ++k) Paa[packed(i, k)] = P[packed(3 * i + 2, 3 * k + 2)];
        }
        cholesky<T>(A, Paa, L);
        solve_lower<T>(A, L, a);
        for (int i = 0; i < A; ++i) sum = sum + a[i] * a[i];
        return sum;
    }
};

}  // namespace jink::inline JINK_LEVEL
