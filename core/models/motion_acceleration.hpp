// Motion models with an acceleration in the state: constant, Singer's, "current" statistical, and a bias that is a random walk.
#pragma once

#include "models/motion.hpp"

namespace jink::inline JINK_LEVEL {

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
    static constexpr bool turn = false, additive = true;
    static constexpr int pattern(int i, int j) {
        if (i / 3 != j / 3 || j < i) return 0;
        return i == j && i % 3 != 2 ? 1 : 2;
    }
    template <class T> static void prepare(const MotionSpec &spec, T dt, const T *parameters, T *c) {
        const T half = 0.5 * dt * dt;
        T q[6];
        c[0] = dt, c[4] = half, c[5] = dt;
        if (spec.kind != MotionKind::constant_acceleration) {
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
    static constexpr bool additive = !Split;
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

}  // namespace jink::inline JINK_LEVEL
