// Noise along the velocity and across it: a variance of each axis, and covariances between axes.
#pragma once

#include "models/motion.hpp"

namespace jink::inline JINK_LEVEL {

// across I + more u u': the variance of each axis, and of each pair of axes, (1, 0), (2, 0), (2, 1), the covariance over the variance of
// the lesser axis.
template <class T> void along_and_across(int axes, const T *u, T across, T more, T *variance, T *ratio) {
    for (int a = 0, pair = 0; a < axes; ++a) {
        variance[a] = across + more * u[a] * u[a];
        for (int b = 0; b < a; ++b) ratio[pair++] = more * u[a] * u[b] * reciprocal(variance[b]);
    }
}

// The velocity over the root of its square and its variance: its direction where it is known, shorter where it is not.
template <class T> void known_direction(const T *x, const T *P, int block, int axes, T *e) {
    T squares = splat<T>(1e-300);
    for (int a = 0; a < axes; ++a) {
        const int v = a * block + 1;
        squares = squares + x[v] * x[v] + P[packed(v, v)];
    }
    const T over = reciprocal_root(squares);
    for (int a = 0; a < axes; ++a) e[a] = x[a * block + 1] * over;
}

// How far r and its change reach along e, and along the rest of r: r = along e + across w, |w| = 1.
template <class T> struct AlongAcross {
    T along, across, change_along, change_across;
    AlongAcross(int axes, const T *e, const T *r, const T *change) {
        const T zero = splat<T>(0.0);
        T squares = splat<T>(1e-300), sum = zero;
        along = change_along = zero;
        for (int a = 0; a < axes; ++a) along = along + r[a] * e[a], change_along = change_along + change[a] * e[a];
        for (int a = 0; a < axes; ++a) {
            const T rest = r[a] - along * e[a];
            squares = squares + rest * rest, sum = sum + rest * change[a];
        }
        across = square_root(squares), change_across = sum * reciprocal_root(squares);
    }
};

}  // namespace jink::inline JINK_LEVEL
