// Motion models that turn in the plane of the first two axes, at an unknown rate or a known one.
#pragma once

#include "models/motion.hpp"

namespace jink::inline JINK_LEVEL {

// sin(a)/a, (1 - cos(a))/a and their derivatives, through a = 0.
template <class T> struct TurnFunctions {
    T sine, cosine, s, c, ds, dc;
    JINK_INLINE explicit TurnFunctions(T a) {
        sine_cosine(a, sine, cosine);
        const Mask<T> small = magnitude(a) < splat<T>(0.1);
        const T z = a * a;
        const T safe = select<T>(small, splat<T>(1.0), a), over = 1.0 / safe;
        const T s_far = sine * over, c_far = (1.0 - cosine) * over;
        const T s_near = 1.0 + z * (-1.0 / 6 + z * (1.0 / 120 + z * (-1.0 / 5040 + z * (1.0 / 362880))));
        const T c_near = a * (0.5 + z * (-1.0 / 24 + z * (1.0 / 720 + z * (-1.0 / 40320 + z * (1.0 / 3628800)))));
        const T ds_near = a * (-1.0 / 3 + z * (1.0 / 30 + z * (-1.0 / 840 + z * (1.0 / 45360))));
        const T dc_near = 0.5 + z * (-1.0 / 8 + z * (1.0 / 144 + z * (-1.0 / 5760 + z * (1.0 / 403200))));
        s = select<T>(small, s_near, s_far);
        c = select<T>(small, c_near, c_far);
        ds = select<T>(small, ds_near, (cosine - s_far) * over);
        dc = select<T>(small, dc_near, (sine - c_far) * over);
    }
};

// Coordinated turn at an unknown rate: [px vx py vy (pz vz) turn_rate], the vertical a constant velocity of its own.
// Coefficients: dt, dt^2/2, (Q00 Q10 Q11) per axis, the turn rate's variance.
// Bar-Shalom, Li & Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 11.7.
template <int A> struct CoordinatedTurn {
    static constexpr int axes = A, block = 2, n = 2 * A + 1, rate = 2 * A, noise_at = 2, noise_terms = 3;
    static constexpr bool turn = true, additive = false;
    static constexpr int pattern(int i, int j) {
        if (i == rate) return j == rate;
        if (i >= 4) return j == rate ? 0 : ConstantVelocity<A>::pattern(i, j);
        if (j == rate || j == 1 || j == 3) return 2;
        return i == j;
    }
    template <class T> static void prepare(const MotionSpec &spec, T dt, const T *parameters, T *c) {
        ConstantVelocity<A>::prepare(spec, dt, parameters, c);
        const T step = spec.turn_noise == NoiseKind::continuous ? dt : only_if_elapsed(dt, splat<T>(1.0));
        c[2 + 3 * A] = parameters[A] * step;
    }
    template <class T> JINK_INLINE static void move(const T *x, const T *c, T *y) {
        const TurnFunctions<T> t(x[rate] * c[0]);
        y[0] = x[0] + c[0] * (t.s * x[1] - t.c * x[3]), y[1] = t.cosine * x[1] - t.sine * x[3];
        y[2] = x[2] + c[0] * (t.c * x[1] + t.s * x[3]), y[3] = t.sine * x[1] + t.cosine * x[3];
        if constexpr (A == 3) y[4] = x[4] + c[0] * x[5], y[5] = x[5];
        y[rate] = x[rate];
    }
    template <class T> JINK_INLINE static void jacobian(const T *x, const T *c, T (&F)[n][n]) {
        const T dt = c[0];
        const TurnFunctions<T> t(x[rate] * dt);
        F[0][1] = dt * t.s, F[0][3] = -(dt * t.c), F[2][1] = dt * t.c, F[2][3] = dt * t.s;
        F[1][1] = t.cosine, F[1][3] = -t.sine, F[3][1] = t.sine, F[3][3] = t.cosine;
        F[0][rate] = dt * dt * (t.ds * x[1] - t.dc * x[3]), F[2][rate] = dt * dt * (t.dc * x[1] + t.ds * x[3]);
        F[1][rate] = -(dt * (t.sine * x[1] + t.cosine * x[3])), F[3][rate] = dt * (t.cosine * x[1] - t.sine * x[3]);
        if constexpr (A == 3) F[4][5] = dt;
    }
    template <class T> JINK_INLINE static void add_noise(const T *c, T *P) {
        ConstantVelocity<A>::add_noise(c, P);
        P[packed(rate, rate)] = P[packed(rate, rate)] + c[2 + 3 * A];
    }
    template <class T> JINK_INLINE static void add_input(const T *u, const T *c, T *x) {
        ConstantVelocity<A>::add_input(u, c, x);
    }
};

// Turn at a known rate. Coefficients as for constant velocity, then S dt, C dt, sine, cosine of the turn.
template <int A> struct KnownTurn {
    static constexpr int axes = A, block = 2, n = 2 * A, turned = 2 + 3 * A, noise_at = 2, noise_terms = 3;
    static constexpr bool turn = false, additive = false;
    static constexpr int pattern(int i, int j) {
        if (i >= 4) return ConstantVelocity<A>::pattern(i, j);
        return j == 1 || j == 3 ? 2 : i == j;
    }
    template <class T> static void prepare(const MotionSpec &spec, T dt, const T *parameters, T *c) {
        ConstantVelocity<A>::prepare(spec, dt, parameters, c);
        const TurnFunctions<T> t(parameters[A] * dt);
        c[turned] = t.s * dt, c[turned + 1] = t.c * dt, c[turned + 2] = t.sine, c[turned + 3] = t.cosine;
    }
    template <class T> JINK_INLINE static void move(const T *x, const T *c, T *y) {
        const T *k = c + turned;
        y[0] = x[0] + k[0] * x[1] - k[1] * x[3], y[1] = k[3] * x[1] - k[2] * x[3];
        y[2] = x[2] + k[1] * x[1] + k[0] * x[3], y[3] = k[2] * x[1] + k[3] * x[3];
        if constexpr (A == 3) y[4] = x[4] + c[0] * x[5], y[5] = x[5];
    }
    template <class T> JINK_INLINE static void jacobian(const T *, const T *c, T (&F)[n][n]) {
        const T *k = c + turned;
        F[0][1] = k[0], F[0][3] = -k[1], F[2][1] = k[1], F[2][3] = k[0];
        F[1][1] = k[3], F[1][3] = -k[2], F[3][1] = k[2], F[3][3] = k[3];
        if constexpr (A == 3) F[4][5] = c[0];
    }
    template <class T> JINK_INLINE static void add_noise(const T *c, T *P) { ConstantVelocity<A>::add_noise(c, P); }
    template <class T> JINK_INLINE static void add_input(const T *u, const T *c, T *x) {
        ConstantVelocity<A>::add_input(u, c, x);
    }
};

}  // namespace jink::inline JINK_LEVEL
