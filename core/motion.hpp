// Motion models: how a state moves over an elapsed time, and how uncertain that is.
//
// A model is a struct of static functions over a number type:
//   prepare(spec, dt, parameters, c)   coefficients of an elapsed time; done again only when the time changes
//   move(x, c, y)                      y = f(x)
//   jacobian(x, c, F)                  F = df/dx, only the entries whose pattern is 2
//   add_noise(c, P)                    P += Q
//   add_input(u, c, x)                 x += G u, u the known acceleration of each axis
// Each axis' share of Q is proportional to its variance, parameters[axis]: `noise_terms` coefficients per axis from `noise_at` on.
// pattern(i, j) says what F_ij is: 0 zero, 1 one, 2 a number. States are interleaved per axis, [p v (a)] ..., then the turn rate.
#pragma once

#include "elementary.hpp"
#include "matrix.hpp"

namespace jink::inline JINK_LEVEL {

enum class MotionKind {
    constant_velocity, constant_acceleration, singer, coordinated_turn, known_turn, current_statistical, augmented, two_stage
};
enum class NoiseKind { piecewise, continuous };  // a constant acceleration over the step (sd), or white noise (psd)

struct MotionSpec {
    MotionKind kind;
    NoiseKind noise, turn_noise;
    int axes;
};

inline constexpr int largest_coefficients = 32;

// G G' of a step's constant acceleration, or the integral of white acceleration noise, as (00, 10, 11).
template <class T> JINK_INLINE void acceleration_noise(NoiseKind kind, T dt, T *q) {
    if (kind == NoiseKind::piecewise) {
        q[0] = dt * dt * dt * dt * 0.25, q[1] = dt * dt * dt * 0.5, q[2] = dt * dt;
    } else {
        q[0] = dt * dt * dt * (1.0 / 3.0), q[1] = dt * dt * 0.5, q[2] = dt;
    }
}

template <class T> JINK_INLINE T only_if_elapsed(T dt, T value) { return select<T>(dt > splat<T>(0.0), value, splat<T>(0.0)); }

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

// Constant velocity: [p v] per axis. Coefficients: dt, dt^2/2, then (Q00 Q10 Q11) per axis.
template <int A> struct ConstantVelocity {
    static constexpr int axes = A, block = 2, n = 2 * A, noise_at = 2, noise_terms = 3;
    static constexpr bool turn = false;
    static constexpr int pattern(int i, int j) { return i == j ? 1 : (i % 2 == 0 && j == i + 1 ? 2 : 0); }
    template <class T> static void prepare(const MotionSpec &spec, T dt, const T *parameters, T *c) {
        T q[3];
        acceleration_noise(spec.noise, dt, q);
        c[0] = dt, c[1] = 0.5 * dt * dt;
        for (int a = 0; a < A; ++a)
            for (int k = 0; k < 3; ++k) c[2 + 3 * a + k] = parameters[a] * q[k];
    }
    template <class T> JINK_INLINE static void move(const T *x, const T *c, T *y) {
        JINK_UNROLL
        for (int a = 0; a < A; ++a) y[2 * a] = x[2 * a] + c[0] * x[2 * a + 1], y[2 * a + 1] = x[2 * a + 1];
    }
    template <class T> JINK_INLINE static void jacobian(const T *, const T *c, T (&F)[n][n]) {
        JINK_UNROLL
        for (int a = 0; a < A; ++a) F[2 * a][2 * a + 1] = c[0];
    }
    template <class T> JINK_INLINE static void add_noise(const T *c, T *P) {
        JINK_UNROLL
        for (int a = 0; a < A; ++a) {
            const T *q = c + 2 + 3 * a;
            P[packed(2 * a, 2 * a)] = P[packed(2 * a, 2 * a)] + q[0];
            P[packed(2 * a + 1, 2 * a)] = P[packed(2 * a + 1, 2 * a)] + q[1];
            P[packed(2 * a + 1, 2 * a + 1)] = P[packed(2 * a + 1, 2 * a + 1)] + q[2];
        }
    }
    template <class T> JINK_INLINE static void add_input(const T *u, const T *c, T *x) {
        for (int a = 0; a < A; ++a) x[2 * a] = x[2 * a] + c[1] * u[a], x[2 * a + 1] = x[2 * a + 1] + c[0] * u[a];
    }
};

// Singer's transition and covariance over dt for a = dt / time constant, unit acceleration variance:
// f = (F02, F12, F22), q = (Q00 Q10 Q11 Q20 Q21 Q22). Below a = 1 the closed forms cancel and their series are used.
// Singer, IEEE Trans. AES-6(4), 1970.
struct SingerSeries {
    static constexpr int terms = 22;
    double c[8][terms];
    constexpr SingerSeries() : c{} {
        double factorial = 1.0, two = 1.0;  // k!, 2^k
        for (int k = 0; k < terms; ++k, two *= 2.0) {
            if (k) factorial *= k;
            const double sign = k % 2 ? -1.0 : 1.0;
            const double f1 = factorial * (k + 1), f2 = f1 * (k + 2), f3 = f2 * (k + 3), f4 = f3 * (k + 4), f5 = f4 * (k + 5);
            c[0][k] = sign / f2;
            c[1][k] = sign / f1;
            c[2][k] = -sign * (4.0 * (k + 5) - 32.0 * two) / f5;
            c[3][k] = sign * (16.0 * two - 2.0 - 2.0 * (k + 4)) / f4;
            c[4][k] = -sign * (4.0 - 8.0 * two) / f3;
            c[5][k] = -sign * (2.0 * (k + 3) - 8.0 * two) / f3;
            c[6][k] = sign * (4.0 * two - 2.0) / f2;
            c[7][k] = sign * 2.0 * two / f1;
        }
    }
};

template <class T> inline void singer_step(T dt, T rate, T *f, T *q) {
    static constexpr SingerSeries series;
    const T a = rate * dt;
    const Mask<T> small = a < splat<T>(1.0);
    const T near = select<T>(small, a, splat<T>(0.0));
    T s[8];
    for (int m = 0; m < 8; ++m) {
        s[m] = splat<T>(series.c[m][series.terms - 1]);
        for (int k = series.terms - 2; k >= 0; --k) s[m] = s[m] * near + series.c[m][k];
    }
    const T e1 = exponential<T>(-a), e2 = e1 * e1;
    const T r2 = rate * rate, r3 = r2 * rate, t2 = dt * dt, t3 = t2 * dt;
    f[0] = select<T>(small, t2 * s[0], (a - 1.0 + e1) / r2);
    f[1] = select<T>(small, dt * s[1], (1.0 - e1) / rate);
    f[2] = e1;
    const T closed[6] = {(1.0 - e2 + 2.0 * a + a * a * a * (2.0 / 3.0) - 2.0 * a * a - 4.0 * a * e1) / (r3 * r2),
                         (e2 + 1.0 - 2.0 * e1 + 2.0 * a * e1 - 2.0 * a + a * a) / (r2 * r2),
                         (4.0 * e1 - 3.0 - e2 + 2.0 * a) / r3,
                         (1.0 - e2 - 2.0 * a * e1) / r3,
                         (e2 + 1.0 - 2.0 * e1) / r2,
                         (1.0 - e2) / rate};
    const T lead[6] = {t3 * t2, t2 * t2, t3, t3, t2, dt};
    for (int k = 0; k < 6; ++k) q[k] = rate * select<T>(small, lead[k] * s[2 + k], closed[k]);
}

// [p v a] per axis: constant acceleration or Singer. Coefficients: F01 F02 F12 F22, G0 G1, then six Q per axis.
template <int A> struct AccelerationState {
    static constexpr int axes = A, block = 3, n = 3 * A, noise_at = 6, noise_terms = 6;
    static constexpr bool turn = false;
    static constexpr int pattern(int i, int j) {
        if (i / 3 != j / 3 || j < i) return 0;
        return i == j && i % 3 != 2 ? 1 : 2;
    }
    template <class T> static void prepare(const MotionSpec &spec, T dt, const T *parameters, T *c) {
        const T half = 0.5 * dt * dt;
        T q[6];
        c[0] = dt, c[4] = half, c[5] = dt;
        if (spec.kind == MotionKind::singer || spec.kind == MotionKind::current_statistical) {
            singer_step<T>(dt, 1.0 / parameters[A], c + 1, q);
        } else {
            c[1] = half, c[2] = dt, c[3] = splat<T>(1.0);
            if (spec.noise == NoiseKind::continuous) {
                q[5] = dt, q[4] = half, q[3] = half * dt * (1.0 / 3.0), q[2] = q[3] * 2.0;
                q[1] = half * half * 0.5, q[0] = q[1] * dt * 0.4;
            } else {
                const T one = only_if_elapsed(dt, splat<T>(1.0));
                q[0] = half * half, q[1] = half * dt, q[2] = dt * dt, q[3] = half, q[4] = dt, q[5] = one;
            }
        }
        for (int a = 0; a < A; ++a)
            for (int k = 0; k < 6; ++k) c[6 + 6 * a + k] = parameters[a] * q[k];
    }
    template <class T> JINK_INLINE static void move(const T *x, const T *c, T *y) {
        JINK_UNROLL
        for (int a = 0; a < A; ++a) {
            const T *from = x + 3 * a;
            y[3 * a] = from[0] + c[0] * from[1] + c[1] * from[2];
            y[3 * a + 1] = from[1] + c[2] * from[2];
            y[3 * a + 2] = c[3] * from[2];
        }
    }
    template <class T> JINK_INLINE static void jacobian(const T *, const T *c, T (&F)[n][n]) {
        JINK_UNROLL
        for (int a = 0; a < A; ++a)
            F[3 * a][3 * a + 1] = c[0], F[3 * a][3 * a + 2] = c[1], F[3 * a + 1][3 * a + 2] = c[2], F[3 * a + 2][3 * a + 2] = c[3];
    }
    template <class T> JINK_INLINE static void add_noise(const T *c, T *P) {
        JINK_UNROLL
        for (int a = 0; a < A; ++a)
            JINK_UNROLL
            for (int i = 0; i < 3; ++i)
                JINK_UNROLL
                for (int j = 0; j < 3; ++j)
                    if (j <= i) P[packed(3 * a + i, 3 * a + j)] = P[packed(3 * a + i, 3 * a + j)] + c[6 + 6 * a + packed(i, j)];
    }
    template <class T> JINK_INLINE static void add_input(const T *u, const T *c, T *x) {
        for (int a = 0; a < A; ++a) x[3 * a] = x[3 * a] + c[4] * u[a], x[3 * a + 1] = x[3 * a + 1] + c[5] * u[a];
    }
};

// "Current" statistical: Singer's acceleration about a mean that is its own last estimate, so that the mean moves with constant
// acceleration and the covariance as Singer's. Zhou & Kumar, J. Guidance 7(5), 1984.
template <int A> struct CurrentStatistical : AccelerationState<A> {
    template <class T> JINK_INLINE static void move(const T *x, const T *c, T *y) {
        JINK_UNROLL
        for (int a = 0; a < A; ++a) {
            const T *from = x + 3 * a;
            y[3 * a] = from[0] + c[0] * from[1] + c[4] * from[2];
            y[3 * a + 1] = from[1] + c[5] * from[2];
            y[3 * a + 2] = from[2];
        }
    }
};

// Constant velocity driven by an acceleration that is a random walk, state [p v a]: white acceleration noise in p and v, and the
// walk's step Qa. `Split`: as the two-stage filter has it, whose bias filter adds Qa to the acceleration's variance M and keeps the
// sensitivity U of position and velocity to it, so that P grows by Qa [U; 1][U; 1]', U = P_xa / M; else it grows in a alone.
// Coefficients: as AccelerationState, but three Q per axis and then Qa per axis.
// Friedland, IEEE Trans. AC-14(4), 1969; Alouani, Xia, Rice & Blair, IEEE Trans. AC-38(5), 1993.
template <int A, bool Split> struct Augmented : AccelerationState<A> {
    static constexpr int noise_at = 6, noise_terms = 3;
    template <class T> static void prepare(const MotionSpec &spec, T dt, const T *parameters, T *c) {
        T q[3];
        acceleration_noise(spec.noise, dt, q);
        c[0] = dt, c[1] = c[4] = 0.5 * dt * dt, c[2] = c[5] = dt, c[3] = splat<T>(1.0);
        for (int a = 0; a < A; ++a) {
            for (int k = 0; k < 3; ++k) c[6 + 3 * a + k] = parameters[a] * q[k];
            c[6 + 3 * A + a] = only_if_elapsed(dt, parameters[A + a]);
        }
    }
    template <class T> JINK_INLINE static void add_noise(const T *c, T *P) {
        for (int a = 0; a < A; ++a) {
            T &pp = P[packed(3 * a, 3 * a)], &vp = P[packed(3 * a + 1, 3 * a)], &vv = P[packed(3 * a + 1, 3 * a + 1)];
            T &ap = P[packed(3 * a + 2, 3 * a)], &av = P[packed(3 * a + 2, 3 * a + 1)], &aa = P[packed(3 * a + 2, 3 * a + 2)];
            const T *q = c + 6 + 3 * a, step = c[6 + 3 * A + a];
            if constexpr (Split) {
                const T over = 1.0 / larger<T>(aa, splat<T>(1e-300)), up = ap * over, uv = av * over;
                pp = pp + step * up * up, vp = vp + step * up * uv, vv = vv + step * uv * uv;
                ap = ap + step * up, av = av + step * uv;
            }
            pp = pp + q[0], vp = vp + q[1], vv = vv + q[2], aa = aa + step;
        }
    }
};

// Coordinated turn at an unknown rate: [px vx py vy (pz vz) turn_rate], the vertical a constant velocity of its own.
// Coefficients: dt, dt^2/2, (Q00 Q10 Q11) per axis, the turn rate's variance.
// Bar-Shalom, Li & Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 11.7.
template <int A> struct CoordinatedTurn {
    static constexpr int axes = A, block = 2, n = 2 * A + 1, rate = 2 * A, noise_at = 2, noise_terms = 3;
    static constexpr bool turn = true;
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
    static constexpr bool turn = false;
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
