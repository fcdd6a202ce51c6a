// Prediction of one mode: x- = f(x) + G u, P- = F P F' + Q. A mode is x (n) followed by its packed covariance.
#pragma once

#include "models/motion.hpp"
#include "scan/mix.hpp"

namespace jink::inline JINK_LEVEL {

// One elapsed time's prediction: `in` and `out` are modes, `c` the model's coefficients, `u` the known acceleration or null.
template <class T> using PredictKernel = void (*)(const T *in, const T *c, const T *u, T *out);
// The same as a matrix: x- , F (row by row) and Q, for the smoothers.
template <class T> using LineariseKernel = void (*)(const T *in, const T *c, const T *u, T *x, T *F, T *Q);
template <class T> using PrepareKernel = void (*)(const MotionSpec &spec, T dt, const T *parameters, T *c);
template <class T> using NoiseKernel = void (*)(const T *c, T *P);
// Mixing (mix.hpp) and then prediction.
template <class T>
using MixPredictKernel = void (*)(const T *arena, const int *places, const T *weights, int modes, const T *c, const T *u, T *out);
// x- alone.
template <class T> using AdvanceKernel = void (*)(const T *in, const T *c, const T *u, T *x);
// B = R' F, row by row, for a packed lower triangular R.
template <class T> using PullKernel = void (*)(const T *in, const T *c, const T *R, T *B);

template <class T> struct MotionKernels {
    PrepareKernel<T> prepare;
    PredictKernel<T> predict;
    LineariseKernel<T> linearise;
    NoiseKernel<T> add_noise;
    int noise_at, noise_terms;  // where the coefficients hold what is proportional to each axis' variance
    bool linear, regressed;     // F is the same whatever the state; F and Q are what linearise says of this state
    AdvanceKernel<T> advance;   // for the smoothers: null for numbers with derivatives, which are not smoothed
    PullKernel<T> pull;
    MixPredictKernel<T> mix_predict;  // where all modes have these components; null where that would not be quicker
    bool turned_noise;          // the last of each axis' terms is a pair's covariance over the lesser axis' variance
    PredictKernel<Value<T>> slope;  // of numbers with slopes, where F and G may have none (see predict_slopes); else null
};

template <class T> inline constexpr bool smoothed = std::is_same_v<T, double> || std::is_same_v<T, Pack>;

// Extended Kalman prediction. Only entries of F that are not known to be 0 or 1 are computed with.
template <class T, class M> void predict(const T *in, const T *c, const T *u, T *out) {
    constexpr int n = M::n, size = packed_size(n);
    T x[n], P[size], F[n][n], FP[n][n], result[size];
    JINK_UNROLL
    for (int i = 0; i < n; ++i) x[i] = in[i];
    JINK_UNROLL
    for (int k = 0; k < size; ++k) P[k] = in[n + k];
    M::jacobian(x, c, F);
    JINK_UNROLL
    for (int i = 0; i < n; ++i)
        JINK_UNROLL
        for (int j = 0; j < n; ++j) {
            T sum = M::pattern(i, i) == 1 ? P[packed(i, j)] : F[i][i] * P[packed(i, j)];
            JINK_UNROLL
            for (int k = 0; k < n; ++k)
                if (k != i && M::pattern(i, k)) sum = sum + F[i][k] * P[packed(k, j)];
            FP[i][j] = sum;
        }
    JINK_UNROLL
    for (int i = 0; i < n; ++i)
        JINK_UNROLL
        for (int j = 0; j < n; ++j)
            if (j <= i) {
                T sum = M::pattern(j, j) == 1 ? FP[i][j] : FP[i][j] * F[j][j];
                JINK_UNROLL
                for (int k = 0; k < n; ++k)
                    if (k != j && M::pattern(j, k)) sum = sum + FP[i][k] * F[j][k];
                if (i == j) {  // see rounding_share: of what was summed, before it cancelled
                    T spread = P[packed(i, i)];
                    JINK_UNROLL
                    for (int k = 0; k < n; ++k)
                        if (k != i && M::pattern(i, k)) spread = spread + F[i][k] * F[i][k] * P[packed(k, k)];
                    sum = sum + rounding_share(n) * spread;
                }
                result[packed(i, j)] = sum;
            }
    M::add_noise(c, result);
    T y[n];
    M::move(x, c, y);
    if (u) M::add_input(u, c, y);
    JINK_UNROLL
    for (int i = 0; i < n; ++i) out[i] = y[i];
    JINK_UNROLL
    for (int k = 0; k < size; ++k) out[n + k] = result[k];
}

// Where F and G have no slopes, prediction is linear in the state, the input and the noise: the slopes move as the values do.
template <WithSlopes T>
void predict_slopes(const MotionKernels<T> &kernels, int axes, int size, const T *in, const T *c, const T *u, T *out) {
    using V = Value<T>;
    constexpr int largest = largest_state + packed_size(largest_state);
    V from[largest], to[largest], coefficients[largest_coefficients], input[3];
    const int coefficients_end = kernels.noise_at + axes * (kernels.noise_terms + 1);
    for (int i = 0; i < kernels.noise_at; ++i) coefficients[i] = c[i].value;
    for (int k = -1; k < T::slopes; ++k) {
        const auto part = [k](auto &x) -> auto & { return k < 0 ? x.value : x.slope[k]; };
        for (int i = 0; i < size; ++i) from[i] = part(in[i]);
        for (int i = kernels.noise_at; i < coefficients_end; ++i) coefficients[i] = part(c[i]);
        for (int a = 0; u && a < axes; ++a) input[a] = part(u[a]);
        kernels.slope(from, coefficients, u ? input : nullptr, to);
        for (int i = 0; i < size; ++i) part(out[i]) = to[i];
    }
}

// Unscented prediction with the 2n symmetric points x +- sqrt(n) L_i, all of weight 1/2n: no point has a negative weight,
// so P- is a sum of squares. Julier & Uhlmann 2004; the same points as the cubature filter's (Arasaratnam & Haykin 2009).
template <class T, class M> void predict_unscented(const T *in, const T *c, const T *u, T *out) {
    constexpr int n = M::n, size = packed_size(n);
    T L[size], points[2 * n][n], mean[n];
    cholesky<T>(n, in + n, L);
    const double spread = std::sqrt(double(n));
    for (int i = 0; i < n; ++i) mean[i] = splat<T>(0.0);
    for (int s = 0; s < 2 * n; ++s) {
        T x[n];
        for (int i = 0; i < n; ++i)
            x[i] = i < s % n ? in[i] : in[i] + (s < n ? spread : -spread) * L[packed(i, s % n)];
        M::move(x, c, points[s]);
        for (int i = 0; i < n; ++i) mean[i] = mean[i] + points[s][i] * (0.5 / n);
    }
    T P[size];
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j) {
            T sum = splat<T>(0.0);
            for (int s = 0; s < 2 * n; ++s) sum = sum + (points[s][i] - mean[i]) * (points[s][j] - mean[j]);
            P[packed(i, j)] = sum * (0.5 / n) * (i == j ? 1.0 + rounding_share(n) : 1.0);
        }
    M::add_noise(c, P);
    if (u) M::add_input(u, c, mean);
    for (int i = 0; i < n; ++i) out[i] = mean[i];
    for (int k = 0; k < size; ++k) out[n + k] = P[k];
}

template <class T, class M> void linearise(const T *in, const T *c, const T *u, T *x, T *F, T *Q) {
    constexpr int n = M::n, size = packed_size(n);
    T J[n][n];
    M::jacobian(in, c, J);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const int kind = M::pattern(i, j);
            F[i * n + j] = kind == 2 ? J[i][j] : splat<T>(kind);
        }
    for (int k = 0; k < size; ++k) Q[k] = splat<T>(0.0);
    M::add_noise(c, Q);
    M::move(in, c, x);
    if (u) M::add_input(u, c, x);
}

// The statistical linearisation that belongs to predict_unscented: F = A L^-1 with A the slopes between opposite points,
// Q grown by what the points' spread exceeds F P F'.
template <class T, class M> void linearise_unscented(const T *in, const T *c, const T *u, T *x, T *F, T *Q) {
    constexpr int n = M::n, size = packed_size(n);
    T L[size], up[n][n], down[n][n];
    cholesky<T>(n, in + n, L);
    const double spread = std::sqrt(double(n));
    for (int i = 0; i < n; ++i) x[i] = splat<T>(0.0);
    for (int s = 0; s < n; ++s) {
        T above[n], below[n];
        for (int i = 0; i < n; ++i) {
            const T step = i < s ? splat<T>(0.0) : spread * L[packed(i, s)];
            above[i] = in[i] + step, below[i] = in[i] - step;
        }
        M::move(above, c, up[s]);
        M::move(below, c, down[s]);
        for (int i = 0; i < n; ++i) x[i] = x[i] + (up[s][i] + down[s][i]) * (0.5 / n);
    }
    for (int k = 0; k < size; ++k) Q[k] = splat<T>(0.0);
    M::add_noise(c, Q);
    for (int i = 0; i < n; ++i) {
        T row[n];
        for (int s = 0; s < n; ++s) row[s] = (up[s][i] - down[s][i]) * (0.5 / spread);
        for (int j = 0; j <= i; ++j) {  // spread about the mean less A A': what a line through the points leaves over
            T sum = splat<T>(0.0);
            for (int s = 0; s < n; ++s)
                sum = sum + (0.5 * (up[s][i] + down[s][i]) - x[i]) * (0.5 * (up[s][j] + down[s][j]) - x[j]);
            Q[packed(i, j)] = Q[packed(i, j)] + sum * (1.0 / n);
        }
        solve_upper<T>(n, L, row);  // row of A times L^-1
        for (int j = 0; j < n; ++j) F[i * n + j] = row[j];
    }
    if (u) M::add_input(u, c, x);
}

template <class T, class M> void advance(const T *in, const T *c, const T *u, T *x) {
    M::move(in, c, x);
    if (u) M::add_input(u, c, x);
}

template <class T, class M> void pull(const T *in, const T *c, const T *R, T *B) {
    constexpr int n = M::n;
    T F[n][n];
    M::jacobian(in, c, F);
    JINK_UNROLL
    for (int r = 0; r < n; ++r)
        JINK_UNROLL
        for (int j = 0; j < n; ++j) {
            T sum = splat<T>(0.0);
            JINK_UNROLL
            for (int i = r; i < n; ++i)
                if (M::pattern(i, j)) sum = sum + (M::pattern(i, j) == 1 ? R[packed(i, r)] : R[packed(i, r)] * F[i][j]);
            B[r * n + j] = sum;
        }
}

// The mixture stays in registers, as far as they go: two or four states.
template <class T, class M>
[[gnu::flatten]] void mix_predict(const T *arena, const int *places, const T *weights, int modes, const T *c, const T *u, T *out) {
    T mixed[M::n + packed_size(M::n)];
    mix<T, M::n, true>(arena, places, weights, modes, mixed);
    predict<T, M>(mixed, c, u, out);
}

template <class T> MotionKernels<T> motion_kernels(const MotionSpec &spec, bool unscented);

template <class T, class M> MotionKernels<T> kernels_of(const MotionSpec &spec, bool unscented) {
    constexpr bool linear = !M::turn;  // every model but the coordinated turn
    MotionKernels<T> k{M::template prepare<T>, predict<T, M>, linearise<T, M>, M::template add_noise<T>, M::noise_at, M::noise_terms,
                       linear, unscented && !linear, nullptr, nullptr, nullptr,
                       spec.kind == MotionKind::statistical_along_track || spec.kind == MotionKind::velocity_along_track, nullptr};
    if constexpr (WithSlopes<T> && M::additive) k.slope = motion_kernels<Value<T>>(spec, unscented).predict;
    if constexpr (smoothed<T>) k.advance = advance<T, M>, k.pull = pull<T, M>;
    if constexpr (std::is_same_v<T, Pack> && !M::turn && M::block == 2 && M::n <= 4) k.mix_predict = mix_predict<T, M>;
    if (unscented && !linear) k.predict = predict_unscented<T, M>, k.linearise = linearise_unscented<T, M>;
    return k;
}

}  // namespace jink::inline JINK_LEVEL
