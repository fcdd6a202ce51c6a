// The measurement update of one mode, one measured component after the other.
//
//   c = P h',  S = h c + R,  x += c (z - h x) / S,  P -= c c' / S
//
// which equals the joint update. The subtraction is kept positive definite by construction (see rounding_share); where a
// component of the state itself is measured its row and column are scaled by R / S instead, without cancellation.
// A missing component has gain zero.
#pragma once

#include "models/motion.hpp"
#include "models/sensor.hpp"
#include "number/dual.hpp"

namespace jink::inline JINK_LEVEL {

// What an update says of its measurement: for the mode's likelihood nis and det; for the rest only if asked.
template <class T> struct Innovation {
    T nis, det;                                           // e' S^-1 e and det S over the measured components
    T e[largest_measurement], S[largest_measurement];     // one after the other, each given those before it
    T y[largest_measurement];                             // z - h(x-), 0 where missing
    T joint[packed_size(largest_measurement)];            // its covariance, 1 on the diagonal where missing
};

template <class T>
using UpdateKernel = void (*)(const SensorSpec &, const Measurement<T> &, const T *in, T *out, Innovation<T> &, bool detail);

template <class T> struct UpdateKernels {
    UpdateKernel<T> position, position_velocity, general, unscented;
};

// c = P h is off by some n^1.5 eps sqrt(P_ii sum h_k^2 P_kk), so c c' / S by that times the root of sum h_k^2 P_kk / S. The diagonal
// grows by as much. Beyond this ratio, along a row in which a thin P cancels, the square root is taken.
inline constexpr double thinnest = 1e4;

// A full R = L D L' with unit lower L makes the errors independent once each measured component of the state (and of z) loses
// L's multiples of those before it; afterwards they are put back. Missing components take no part.
template <class T, int A, int B, int N, int Rows> struct Decorrelate {
    T L[packed_size(Rows)], D[Rows];
    Mask<T> thin = splat_mask<T>(false);  // R, or the state's covariance, is so thin along it that a variance is mostly rounding
    static constexpr int place(int r) { return (r % A) * B + r / A; }

    explicit Decorrelate(const Measurement<T> &m) {
        const T zero = splat<T>(0.0), one = splat<T>(1.0);
        for (int r = 0; r < Rows; ++r)
            for (int q = 0; q <= r; ++q) {
                T sum = select<T>(m.present[r] & m.present[q], m.R[packed(r, q)], q == r ? one : zero);
                for (int k = 0; k < q; ++k) sum = sum - L[packed(r, k)] * L[packed(q, k)] * D[k];
                if (q == r) {
                    const T whole = select<T>(m.present[r], m.R[packed(r, r)], one);
                    thin = thin | (thinnest * sum < whole);
                    D[r] = larger<T>(sum, rounding_share(Rows) * whole), L[packed(r, r)] = one;
                }
                else L[packed(r, q)] = sum / D[q];
            }
    }

    // Row r of the state loses the multiples of the rows before it, which have been updated already: of a state that is far less
    // certain than the measurement they would be so large that what is left were rounding.
    void lose(int r, T *x, T *P) {
        for (int q = 0; q < r; ++q) add(place(r), place(q), -L[packed(r, q)], x, P);
    }

    // All rows regain them.
    void regain(T *x, T *P) {
        for (int r = Rows - 1; r > 0; --r)
            for (int q = r - 1; q >= 0; --q) add(place(r), place(q), L[packed(r, q)], x, P);
    }

    // Component r of the measurement less them.
    T left(const Measurement<T> &m, int r, const T *z) const {
        T one = m.z[r];
        for (int q = 0; q < r; ++q) one = one - select<T>(m.present[q], L[packed(r, q)] * z[q], splat<T>(0.0));
        return one;
    }

    // Where a variance cancels, it is thin.
    void add(int p, int q, T l, T *x, T *P) {
        x[p] = x[p] + l * x[q];
        const T corner = P[packed(p, p)] + l * (2.0 * P[packed(p, q)] + l * P[packed(q, q)]);
        for (int i = 0; i < N; ++i)
            if (i != p) P[packed(p, i)] = P[packed(p, i)] + l * P[packed(q, i)];
        P[packed(p, p)] = corner;
        thin = thin | (thinnest * corner < l * l * P[packed(q, q)]);
    }
};

// One row's S, c = P h and P after it, which goes where the caller keeps it, by a square root of P: with P = L L' and f = L' h,
//   S = f' f + R,  c = L f,  P = W W',  W = L - c f' / (S + sqrt(S R)).
// Sums of squares throughout, so nothing cancels. Potter; Bierman, Factorization Methods for Discrete Sequential Estimation, 1977.
template <class T, int N> struct FactoredRow {
    T S, c[N];

    [[gnu::noinline]] FactoredRow(const T *h, const T *before, T R, T *after) {
        T L[packed_size(N)], W[N * N], f[N];
        cholesky<T>(N, before, L);
        S = R;
        for (int k = 0; k < N; ++k) {
            f[k] = h[k] * L[packed(k, k)];
            for (int i = k + 1; i < N; ++i) f[k] = f[k] + h[i] * L[packed(i, k)];
            S = S + f[k] * f[k];
        }
        const T share = 1.0 / (S + square_root(S * R));
        for (int i = 0; i < N; ++i) {
            c[i] = L[packed(i, 0)] * f[0];
            for (int k = 1; k <= i; ++k) c[i] = c[i] + L[packed(i, k)] * f[k];
            for (int k = 0; k < N; ++k) W[i * N + k] = (k <= i ? L[packed(i, k)] : splat<T>(0.0)) - c[i] * share * f[k];
        }
        for (int i = 0; i < N; ++i)
            for (int j = 0; j <= i; ++j) {
                T sum = W[i * N] * W[j * N];
                for (int k = 1; k < N; ++k) sum = sum + W[i * N + k] * W[j * N + k];
                after[packed(i, j)] = sum;
            }
    }
};

// Rows H with residual y about the predicted state; R packed if `full`, else variances.
template <class T, int N>
void update_rows(int rows, const Mask<T> *present, T *y, T *H, T *R, bool full, const T *in, T *out, Innovation<T> &v, bool detail) {
    constexpr int size = packed_size(N);
    const T zero = splat<T>(0.0), one = splat<T>(1.0);
    T scale[largest_measurement];
    for (int r = 0; r < rows; ++r) {
        scale[r] = one;
        y[r] = select<T>(present[r], y[r], zero);
        for (int k = 0; k < N; ++k) H[r * N + k] = select<T>(present[r], H[r * N + k], zero);
    }
    if (full)
        for (int r = 0; r < rows; ++r)
            for (int q = 0; q <= r; ++q)
                R[packed(r, q)] = select<T>(present[r] & present[q], R[packed(r, q)], q == r ? one : zero);
    if (detail)
        for (int r = 0; r < rows; ++r) {
            T c[N];
            for (int i = 0; i < N; ++i) {
                c[i] = zero;
                for (int k = 0; k < N; ++k) c[i] = c[i] + H[r * N + k] * in[N + packed(i, k)];
            }
            v.y[r] = y[r];
            for (int q = 0; q <= r; ++q) {
                T S = full ? R[packed(r, q)] : (q == r ? select<T>(present[r], R[r], one) : zero);
                for (int k = 0; k < N; ++k) S = S + H[q * N + k] * c[k];
                v.joint[packed(r, q)] = S;
            }
        }
    if (full) {  // whiten: L^-1 y, L^-1 H, unit noise
        T L[packed_size(largest_measurement)], column[largest_measurement];
        cholesky<T>(rows, R, L);
        solve_lower<T>(rows, L, y);
        for (int k = 0; k < N; ++k) {
            for (int r = 0; r < rows; ++r) column[r] = H[r * N + k];
            solve_lower<T>(rows, L, column);
            for (int r = 0; r < rows; ++r) H[r * N + k] = column[r];
        }
        for (int r = 0; r < rows; ++r) scale[r] = L[packed(r, r)], R[r] = one;
    }
    T moved[N], P[size], factored[size];
    for (int i = 0; i < N; ++i) moved[i] = zero;
    JINK_UNROLL
    for (int k = 0; k < size; ++k) P[k] = in[N + k];
    T nis = zero, det = one;
    for (int r = 0; r < rows; ++r) {
        const T *h = H + r * N;
        T c[N], e = y[r], S = R[r];
        JINK_UNROLL
        for (int i = 0; i < N; ++i) {
            c[i] = h[0] * P[packed(i, 0)];
            JINK_UNROLL
            for (int k = 1; k < N; ++k) c[i] = c[i] + h[k] * P[packed(i, k)];
        }
        JINK_UNROLL
        for (int k = 0; k < N; ++k) S = S + h[k] * c[k], e = e - h[k] * moved[k];
        T spread = h[0] * h[0] * P[0];
        JINK_UNROLL
        for (int k = 1; k < N; ++k) spread = spread + h[k] * h[k] * P[packed(k, k)];
        const Mask<T> thin = present[r] & (spread > thinnest * S);
        if (__builtin_expect(any(thin), 0)) {
            const FactoredRow<T, N> row(h, P, R[r], factored);
            S = select<T>(thin, row.S, S);
            for (int i = 0; i < N; ++i) c[i] = select<T>(thin, row.c[i], c[i]);
        }
        const T inverse_S = reciprocal(S);
        const T gain = select<T>(present[r], inverse_S, zero), scaled = gain * e;
        const T grown = 1.0 + rounding_share(N) * square_root(larger<T>(spread * gain, one));
        nis = nis + scaled * e;
        det = det * select<T>(present[r], S * scale[r] * scale[r], one);
        if (detail) v.e[r] = e * scale[r], v.S[r] = select<T>(present[r], S * scale[r] * scale[r], one);
        JINK_UNROLL
        for (int i = 0; i < N; ++i) moved[i] = moved[i] + c[i] * scaled;
        JINK_UNROLL
        for (int i = 0; i < N; ++i) {
            const T g = c[i] * gain;
            JINK_UNROLL
            for (int j = 0; j < N; ++j) {
                if (j > i) continue;
                const T kept = i == j ? P[packed(i, i)] * grown : P[packed(i, j)];
                P[packed(i, j)] = kept - g * c[j];
            }
        }
        if (__builtin_expect(any(thin), 0))
            for (int k = 0; k < size; ++k) P[k] = select<T>(thin, factored[k], P[k]);
    }
    v.nis = nis, v.det = det;
    JINK_UNROLL
    for (int i = 0; i < N; ++i) out[i] = in[i] + moved[i];
    JINK_UNROLL
    for (int k = 0; k < size; ++k) out[N + k] = P[k];
}

// Components of the state as rows of H, for a full R that is too thin to be decorrelated by a triangle of unit diagonal.
template <class T, int A, int B, int N, int Rows>
[[gnu::noinline]] void update_thin(const Measurement<T> &m, const T *in, T *out, Innovation<T> &v, bool detail) {
    T y[largest_measurement], H[largest_measurement * N], R[packed_size(largest_measurement)];
    for (int k = 0; k < Rows * N; ++k) H[k] = splat<T>(0.0);
    for (int r = 0; r < Rows; ++r) {
        const int p = Decorrelate<T, A, B, N, Rows>::place(r);
        y[r] = m.z[r] - in[p], H[r * N + p] = splat<T>(1.0);
    }
    for (int k = 0; k < packed_size(Rows); ++k) R[k] = m.R[k];
    update_rows<T, N>(Rows, m.present, y, H, R, true, in, out, v, detail);
}

// What the slopes of a row are made of: gain = 1 / S or 0, kept = R / S or 1, scaled = e / S, c = P h.
template <class T, int N> struct DirectTerms {
    T gain, kept, scaled, c[N];
};

// Component p of the state is measured as z with variance R, or is missing. Kept: its terms go to `terms`.
template <class T, int N, bool Kept = false> struct DirectRow {
    T e, S, nis;

    JINK_INLINE DirectRow(int p, Mask<T> present, T z, T R, T *x, T *P, [[maybe_unused]] DirectTerms<T, N> *terms = nullptr) {
        const T zero = splat<T>(0.0), one = splat<T>(1.0), variance = P[packed(p, p)] + R;
        const T inverse_S = reciprocal(variance);
        e = select<T>(present, z - x[p], zero);
        S = select<T>(present, variance, one);
        const T gain = select<T>(present, inverse_S, zero), kept = select<T>(present, R * inverse_S, one), scaled = gain * e;
        nis = scaled * e;
        T c[N];
        JINK_UNROLL
        for (int i = 0; i < N; ++i) c[i] = P[packed(i, p)];
        if constexpr (Kept) {
            terms->gain = gain, terms->kept = kept, terms->scaled = scaled;
            std::copy(c, c + N, terms->c);
        }
        JINK_UNROLL
        for (int i = 0; i < N; ++i) x[i] = x[i] + c[i] * scaled;
        JINK_UNROLL
        for (int i = 0; i < N; ++i) {
            const T g = c[i] * gain;
            JINK_UNROLL
            for (int j = 0; j < N; ++j) {
                if (j > i) continue;
                if (i == p || j == p) P[packed(i, j)] = P[packed(i, j)] * kept;
                else if (i == j) P[packed(i, i)] = P[packed(i, i)] * (1.0 + rounding_share(N)) - g * c[i];
                else P[packed(i, j)] = P[packed(i, j)] - g * c[j];
            }
        }
    }
};

// The slopes of all rows, one slope after the other. A row's, with g = c / S and b = c' - g S'/2 :
//   x' += c' e/S + c (e/S)' ,   P' -= g b' + b g' ,   and where the component itself stands  (c R/S)'
template <WithSlopes T, int A, int B, int N, int Rows>
void direct_slopes(const Measurement<T> &m, const DirectTerms<Value<T>, N> *terms, const T *in, T *out, Innovation<T> &v, bool detail) {
    using V = Value<T>;
    constexpr int size = packed_size(N);
    for (int k = 0; k < T::slopes; ++k) {
        V x[N], P[size], nis = splat<V>(0.0), log_det = nis;
        JINK_UNROLL_PACKS
        for (int i = 0; i < N; ++i) x[i] = in[i].slope[k];
        JINK_UNROLL_PACKS
        for (int i = 0; i < size; ++i) P[i] = in[N + i].slope[k];
        JINK_UNROLL_PACKS
        for (int r = 0; r < Rows; ++r) {
            const DirectTerms<V, N> &row = terms[r];
            const int p = (r % A) * B + r / A;
            const V S = P[packed(p, p)] + m.R[r].slope[k], half = 0.5 * row.gain * S;
            const V e = m.z[r].slope[k] - x[p], scaled = row.gain * (e - row.scaled * S), kept = row.gain * (m.R[r].slope[k] - row.kept * S);
            if (detail) v.e[r].slope[k] = select<V>(m.present[r], e, splat<V>(0.0)), v.S[r].slope[k] = select<V>(m.present[r], S, splat<V>(0.0));
            nis = nis + row.scaled * (2.0 * e - row.scaled * S), log_det = log_det + row.gain * S;
            V c[N], g[N], b[N];
            JINK_UNROLL_PACKS
            for (int i = 0; i < N; ++i) {
                c[i] = P[packed(i, p)], g[i] = row.c[i] * row.gain, b[i] = c[i] - row.c[i] * half;
                x[i] = x[i] + c[i] * row.scaled + row.c[i] * scaled;
            }
            JINK_UNROLL_PACKS
            for (int i = 0; i < N; ++i)
                JINK_UNROLL_PACKS
                for (int j = 0; j < N; ++j) {
                    if (j > i) continue;
                    if (i == p || j == p) P[packed(i, j)] = c[i == p ? j : i] * row.kept + row.c[i == p ? j : i] * kept;
                    else if (i == j) P[packed(i, i)] = P[packed(i, i)] - g[i] * (b[i] + b[i]);
                    else P[packed(i, j)] = P[packed(i, j)] - g[i] * b[j] - b[i] * g[j];
                }
        }
        v.nis.slope[k] = nis, v.det.slope[k] = log_det * v.det.value;
        JINK_UNROLL_PACKS
        for (int i = 0; i < N; ++i) out[i].slope[k] = x[i];
        JINK_UNROLL_PACKS
        for (int i = 0; i < size; ++i) out[N + i].slope[k] = P[i];
    }
}

// Components of the state with a full R.
template <class T, int A, int B, int N, int Rows>
[[gnu::noinline]] void update_correlated(const Measurement<T> &m, const T *in, T *out, Innovation<T> &v, bool detail) {
    constexpr int size = packed_size(N);
    T x[N], P[size], z[Rows];
    for (int i = 0; i < N; ++i) x[i] = in[i];
    for (int k = 0; k < size; ++k) P[k] = in[N + k];
    Decorrelate<T, A, B, N, Rows> change(m);
    v.nis = splat<T>(0.0), v.det = splat<T>(1.0);
    for (int r = 0; r < Rows; ++r) {
        change.lose(r, x, P);
        z[r] = change.left(m, r, z);
        const DirectRow<T, N> row(change.place(r), m.present[r], z[r], change.D[r], x, P);
        v.nis = v.nis + row.nis, v.det = v.det * row.S;
        if (detail) v.e[r] = row.e, v.S[r] = row.S;
    }
    change.regain(x, P);
    for (int i = 0; i < N; ++i) out[i] = x[i];
    for (int k = 0; k < size; ++k) out[N + k] = P[k];
    if (!any(change.thin)) return;
    T other[N + size];
    Innovation<T> in_other;
    update_thin<T, A, B, N, Rows>(m, in, other, in_other, detail);
    for (int k = 0; k < N + size; ++k) out[k] = select<T>(change.thin, other[k], out[k]);
    v.nis = select<T>(change.thin, in_other.nis, v.nis), v.det = select<T>(change.thin, in_other.det, v.det);
    for (int r = 0; r < Rows && detail; ++r)
        v.e[r] = select<T>(change.thin, in_other.e[r], v.e[r]), v.S[r] = select<T>(change.thin, in_other.S[r], v.S[r]);
}

// Position, or position and velocity: components of the state itself are measured.
template <class T, int A, int B, int N, bool Velocity>
void update_direct(const SensorSpec &, const Measurement<T> &m, const T *in, T *out, Innovation<T> &v, bool detail) {
    constexpr int rows = Velocity ? 2 * A : A, size = packed_size(N);
    const T zero = splat<T>(0.0), one = splat<T>(1.0);
    if (detail) {
        for (int r = 0; r < rows; ++r) {
            const int p = (r % A) * B + r / A;
            v.y[r] = select<T>(m.present[r], m.z[r] - in[p], zero);
            for (int q = 0; q <= r; ++q) {
                const T noise = m.full ? m.R[packed(r, q)] : q == r ? m.R[r] : zero;
                const T S = in[N + packed(p, (q % A) * B + q / A)] + noise;
                v.joint[packed(r, q)] = select<T>(m.present[r] & m.present[q], S, q == r ? one : zero);
            }
        }
    }
    if (m.full) return update_correlated<T, A, B, N, rows>(m, in, out, v, detail);
    using V = Value<T>;
    V x[N], P[size], nis = splat<V>(0.0), det = splat<V>(1.0);
    [[maybe_unused]] DirectTerms<V, N> terms[rows];
    JINK_UNROLL
    for (int i = 0; i < N; ++i) x[i] = value_of(in[i]);
    JINK_UNROLL
    for (int k = 0; k < size; ++k) P[k] = value_of(in[N + k]);
    JINK_UNROLL
    for (int r = 0; r < rows; ++r) {
        const DirectRow<V, N, WithSlopes<T>> row((r % A) * B + r / A, m.present[r], value_of(m.z[r]), value_of(m.R[r]), x, P, &terms[r]);
        nis = nis + row.nis, det = det * row.S;
        if (detail) value_of(v.e[r]) = row.e, value_of(v.S[r]) = row.S;
    }
    value_of(v.nis) = nis, value_of(v.det) = det;
    if constexpr (WithSlopes<T>) direct_slopes<T, A, B, N, rows>(m, terms, in, out, v, detail);
    JINK_UNROLL
    for (int i = 0; i < N; ++i) value_of(out[i]) = x[i];
    JINK_UNROLL
    for (int k = 0; k < size; ++k) value_of(out[N + k]) = P[k];
}

// Any sensor, linearised at the predicted state (extended Kalman filter).
template <class T, int B, int N>
void update_general(const SensorSpec &spec, const Measurement<T> &m, const T *in, T *out, Innovation<T> &v, bool detail) {
    T y[largest_measurement], H[largest_measurement * N], R[packed_size(largest_measurement)];
    observe(spec, B, N, in, y);
    residual(spec, m.z, y, y);
    observe_jacobian(spec, B, N, in, H);
    for (int k = 0; k < (m.full ? packed_size(spec.rows) : spec.rows); ++k) R[k] = m.R[k];
    update_rows<T, N>(spec.rows, m.present, y, H, R, m.full, in, out, v, detail);
}

// Any sensor by statistical linearisation over the symmetric points of predict_unscented: the regression of h on x,
// what it leaves over added to R. Equal to the unscented update, and as safe as the linear one.
template <class T, int B, int N>
void update_unscented(const SensorSpec &spec, const Measurement<T> &m, const T *in, T *out, Innovation<T> &v, bool detail) {
    constexpr int M = largest_measurement;
    T L[packed_size(N)], centre[M], y[M], H[M * N], R[packed_size(M)], up[N][M], down[N][M], mean[M];
    const double spread = std::sqrt(double(N));
    const int rows = spec.rows;
    cholesky<T>(N, in + N, L);
    observe(spec, B, N, in, centre);
    for (int r = 0; r < rows; ++r) mean[r] = splat<T>(0.0);
    for (int s = 0; s < N; ++s) {
        T above[N], below[N];
        for (int i = 0; i < N; ++i) {
            const T step = i < s ? splat<T>(0.0) : spread * L[packed(i, s)];
            above[i] = in[i] + step, below[i] = in[i] - step;
        }
        observe(spec, B, N, above, up[s]);
        observe(spec, B, N, below, down[s]);
        residual(spec, up[s], centre, up[s]);
        residual(spec, down[s], centre, down[s]);
        for (int r = 0; r < rows; ++r) mean[r] = mean[r] + (up[s][r] + down[s][r]) * (0.5 / N);
    }
    residual(spec, m.z, centre, y);
    for (int r = 0; r < rows; ++r) {
        y[r] = y[r] - mean[r];
        T slopes[N];
        for (int s = 0; s < N; ++s) slopes[s] = (up[s][r] - down[s][r]) * (0.5 / spread);
        solve_upper<T>(N, L, slopes);
        for (int k = 0; k < N; ++k) H[r * N + k] = slopes[k];
        for (int q = 0; q <= r; ++q) {
            T sum = splat<T>(0.0);
            for (int s = 0; s < N; ++s)
                sum = sum + (0.5 * (up[s][r] + down[s][r]) - mean[r]) * (0.5 * (up[s][q] + down[s][q]) - mean[q]);
            const T noise = m.full ? m.R[packed(r, q)] : (q == r ? m.R[r] : splat<T>(0.0));
            R[packed(r, q)] = noise + sum * (1.0 / N);
        }
    }
    update_rows<T, N>(rows, m.present, y, H, R, true, in, out, v, detail);
}

template <class T> UpdateKernels<T> update_kernels(const StateShape &shape);

}  // namespace jink::inline JINK_LEVEL
