// Motion models: how a state moves over an elapsed time, and how uncertain that is.
//
// A model is a struct of static functions over a number type:
//   prepare(spec, dt, parameters, c)   coefficients of an elapsed time; done again only when the time changes
//   move(x, c, y)                      y = f(x)
//   jacobian(x, c, F)                  F = df/dx, only the entries whose pattern is 2
//   add_noise(c, P)                    P += Q
//   add_input(u, c, x)                 x += G u, u the known acceleration of each axis
// Each axis' share of Q is proportional to its variance, parameters[axis]: `noise_terms` coefficients per axis from `noise_at` on.
// `additive`: those from noise_at on are added to P, and all others belong to F and G.
// pattern(i, j) says what F_ij is: 0 zero, 1 one, 2 a number. States are interleaved per axis, [p v (a)] ..., then the turn rate.
#pragma once

#include "number/elementary.hpp"
#include "number/matrix.hpp"

namespace jink::inline JINK_LEVEL {

enum class MotionKind {
    constant_velocity, constant_acceleration, singer, coordinated_turn, known_turn, current_statistical, augmented, two_stage,
    statistical_along_track, velocity_along_track
};
enum class NoiseKind { piecewise, continuous };  // a constant acceleration over the step (sd), or white noise (psd)

struct MotionSpec {
    MotionKind kind;
    NoiseKind noise, turn_noise;
    int axes;
};

// The components of a state: `block` per axis, [p v] or [p v a], then the turn rate if there is one.
struct StateShape {
    int axes, block, n;
    bool turn;
};

inline StateShape shape_of(MotionKind kind, int axes) {
    const bool turn = kind == MotionKind::coordinated_turn;
    const bool velocity = turn || kind == MotionKind::constant_velocity || kind == MotionKind::known_turn ||
                          kind == MotionKind::velocity_along_track;
    const int block = velocity ? 2 : 3;
    return {axes, block, axes * block + turn, turn};
}

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

// Constant velocity: [p v] per axis. Coefficients: dt, dt^2/2, then (Q00 Q10 Q11) per axis.
template <int A> struct ConstantVelocity {
    static constexpr int axes = A, block = 2, n = 2 * A, noise_at = 2, noise_terms = 3;
    static constexpr bool turn = false, additive = true;
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

// A model whose noise lies along and across the velocity, so that axes are correlated. Coefficients: as the model's, but after each
// axis' Q the covariance of a pair of axes, (1, 0), (2, 0), (2, 1), over the variance of the lesser axis.
template <class Plain> struct AlongTrack : Plain {
    static constexpr int axes = Plain::axes, block = Plain::block, noise_at = Plain::noise_at, own = Plain::noise_terms;
    static constexpr int noise_terms = own + 1;
    static constexpr bool additive = false;
    template <class T> static void prepare(const MotionSpec &spec, T dt, const T *parameters, T *c) {
        T plain[noise_at + own * axes];
        Plain::prepare(spec, dt, parameters, plain);
        for (int k = 0; k < noise_at; ++k) c[k] = plain[k];
        for (int a = 0; a < axes; ++a) {
            for (int k = 0; k < own; ++k) c[noise_at + noise_terms * a + k] = plain[noise_at + own * a + k];
            c[noise_at + noise_terms * a + own] = splat<T>(0.0);
        }
    }
    template <class T> JINK_INLINE static void add_noise(const T *c, T *P) {
        for (int a = 0, pair = 0; a < axes; ++a) {
            const T *q = c + noise_at + noise_terms * a;
            for (int i = 0; i < block; ++i)
                for (int j = 0; j <= i; ++j) {
                    T &at = P[packed(block * a + i, block * a + j)];
                    at = at + q[packed(i, j)];
                }
            for (int b = 0; b < a; ++b) {
                const T ratio = c[noise_at + noise_terms * pair++ + own], *lesser = c + noise_at + noise_terms * b;
                for (int i = 0; i < block; ++i)
                    for (int j = 0; j < block; ++j) {
                        T &at = P[packed(block * a + i, block * b + j)];
                        at = at + ratio * lesser[packed(i, j)];
                    }
            }
        }
    }
};

}  // namespace jink::inline JINK_LEVEL
