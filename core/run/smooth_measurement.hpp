// What a scan measured, added to a message about a mode's filtered estimate: J += H' R^-1 H, h += H' R^-1 y, s -= 1/2 y' R^-1 y.
#pragma once

#include "run/record.hpp"
#include "run/smooth_message.hpp"

namespace jink::inline JINK_LEVEL {

// Components of the state themselves: the inverse of their noise, packed, 0 where one is missing. It serves every mode.
template <class T> void weigh_components(const SensorSpec &spec, const Measurement<T> &z, T *W) {
    constexpr int M = largest_measurement;
    const int rows = spec.rows;
    const T zero = splat<T>(0.0), one = splat<T>(1.0);
    if (!z.full) {
        for (int r = 0; r < rows; ++r) W[packed(r, r)] = select<T>(z.present[r], 1.0 / z.R[r], zero);
        return;
    }
    T R[packed_size(M)], chol[packed_size(M)], root[M * M];
    for (int r = 0; r < rows; ++r)
        for (int q = 0; q <= r; ++q) R[packed(r, q)] = select<T>(z.present[r] & z.present[q], z.R[packed(r, q)], q == r ? one : zero);
    cholesky<T>(rows, R, chol);
    for (int r = 0; r < rows; ++r) {  // column r of the factor's inverse
        T *column = root + r * M;
        for (int q = 0; q < rows; ++q) column[q] = q == r ? one : zero;
        solve_lower<T>(rows, chol, column);
    }
    for (int r = 0; r < rows; ++r)
        for (int q = 0; q <= r; ++q) {
            T sum = zero;
            for (int k = r; k < rows; ++k) sum = sum + root[r * M + k] * root[q * M + k];
            W[packed(r, q)] = select<T>(z.present[r] & z.present[q], sum, zero);
        }
}

template <class T>
void add_components(const Mode<T> &mode, const T *x, const SensorSpec &spec, const Measurement<T> &z, const T *W, Message<T> &m) {
    T y[largest_measurement];
    int at[largest_measurement];
    for (int r = 0; r < spec.rows; ++r) {
        at[r] = (r % spec.axes) * mode.shape.block + r / spec.axes;
        y[r] = select<T>(z.present[r], z.z[r] - x[at[r]], splat<T>(0.0));
    }
    for (int r = 0; r < spec.rows; ++r) {
        T h = W[packed(r, r)] * y[r];
        for (int q = 0; z.full && q < spec.rows; ++q)
            if (q != r) h = h + W[packed(r, q)] * y[q];
        m.h[at[r]] = m.h[at[r]] + h;
        m.s = m.s - 0.5 * h * y[r];
        for (int q = z.full ? 0 : r; q <= r; ++q) m.J[packed(at[r], at[q])] = m.J[packed(at[r], at[q])] + W[packed(r, q)];
    }
}

// Any sensor, linearised at x.
template <class T> void add_rows(const Mode<T> &mode, const T *x, const SensorSpec &spec, const Measurement<T> &z, Message<T> &m) {
    constexpr int M = largest_measurement, L = largest_state;
    const int n = mode.shape.n;
    const T zero = splat<T>(0.0), one = splat<T>(1.0);
    T y[M], H[M * L], R[packed_size(M)], chol[packed_size(M)], column[M];
    observe(spec, mode.shape.block, n, x, y);
    residual(spec, z.z, y, y);
    observe_jacobian(spec, mode.shape.block, n, x, H);
    for (int r = 0; r < spec.rows; ++r) {
        y[r] = select<T>(z.present[r], y[r], zero);
        for (int k = 0; k < n; ++k) H[r * n + k] = select<T>(z.present[r], H[r * n + k], zero);
        for (int q = 0; q <= r; ++q) {
            const T noise = z.full ? z.R[packed(r, q)] : q == r ? z.R[r] : zero;
            R[packed(r, q)] = select<T>(z.present[r] & z.present[q], noise, q == r ? one : zero);
        }
    }
    cholesky<T>(spec.rows, R, chol);
    solve_lower<T>(spec.rows, chol, y);
    for (int k = 0; k < n; ++k) {
        for (int r = 0; r < spec.rows; ++r) column[r] = H[r * n + k];
        solve_lower<T>(spec.rows, chol, column);
        for (int r = 0; r < spec.rows; ++r) H[r * n + k] = column[r];
    }
    for (int r = 0; r < spec.rows; ++r) {
        m.s = m.s - 0.5 * y[r] * y[r];
        for (int k = 0; k < n; ++k) {
            m.h[k] = m.h[k] + H[r * n + k] * y[r];
            for (int l = 0; l <= k; ++l) m.J[packed(k, l)] = m.J[packed(k, l)] + H[r * n + k] * H[r * n + l];
        }
    }
}

}  // namespace jink::inline JINK_LEVEL
