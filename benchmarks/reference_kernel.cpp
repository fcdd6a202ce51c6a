// A filter written by hand for one case alone: what jink's engine, which runs any filter, is held against.
//
// IMM of three constant velocities, 4 states [px vx py vy], positions measured, one step for all scans, full covariances; states and
// log-likelihoods out. One target per vector lane. Covariances are packed lower triangles, as in core/number/matrix.hpp.
// Bar-Shalom, Li & Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, 11.6.6.
//
// Compiled by reference_kernel.py: c++ -O3 -march=native -fno-math-errno -fno-trapping-math -shared
#include <cstdint>
#include <cstring>
#include <initializer_list>

#if defined(__AVX512F__)
#include <immintrin.h>
constexpr int lanes = 8;
#elif defined(__AVX__)
constexpr int lanes = 4;
#else
constexpr int lanes = 2;
#endif

#define UNROLLED _Pragma("GCC unroll 16")

namespace {

typedef double V __attribute__((vector_size(8 * lanes)));
typedef std::int64_t Bits __attribute__((vector_size(8 * lanes)));
constexpr int modes = 3, n = 4, size = 10, block = 32;

// 1 / x, and 1 / sqrt(x). With AVX-512 an estimate of 14 bits and the first terms of the series of what it is off by.
V over(V x) {
#if defined(__AVX512F__)
    const V y = (V)_mm512_rcp14_pd((__m512d)x), off = 1.0 - x * y, once = y + y * off;
    return once + once * (off * off);
#else
    return 1.0 / x;
#endif
}
V over_root(V x) {
#if defined(__AVX512F__)
    const V y = (V)_mm512_rsqrt14_pd((__m512d)x), off = 1.0 - (x * y) * y;
    return y + (y * off) * (0.5 + off * (0.375 + off * 0.3125));
#else
    V root;
    UNROLLED for (int l = 0; l < lanes; ++l) root[l] = __builtin_sqrt(x[l]);
    return 1.0 / root;
#endif
}

// e^x for x <= 0: x = k ln 2 + r, and the series of e^r.
V exponential(V x) {
    constexpr double shift = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to an integer held in the low bits
    x = x < -708.0 ? V{} - 708.0 : x;
    const V shifted = x * 1.4426950408889634 + shift, k = shifted - shift;
    const V r = (x - k * 6.93147180369123816490e-01) - k * 1.90821492927058770002e-10;
    V p = V{} + 1.0 / 6227020800.0;
    for (double c : {1 / 479001600.0, 1 / 39916800.0, 1 / 3628800.0, 1 / 362880.0, 1 / 40320.0, 1 / 5040.0, 1 / 720.0, 1 / 120.0, 1 / 24.0,
                     1 / 6.0, 0.5, 1.0, 1.0})
        p = p * r + c;
    return p * (V)(((Bits)shifted << 52) + (Bits)(V{} + 1.0));
}

// The logarithm of a product of many numbers: its mantissa, and its exponent beside it.
struct Product {
    V mantissa = V{} + 1.0, exponent = V{};
    void operator*=(V x) {
        const V product = mantissa * x;
        const Bits k = ((Bits)product >> 52) - 1023;
        mantissa = (V)((Bits)product - (k << 52));
        exponent += (V)(k + std::int64_t(0x4338000000000000)) - 6755399441055744.0;
    }
    double log(int l) const { return __builtin_log(mantissa[l]) + exponent[l] * 0.693147180559945309417; }
};

struct Mode {
    V x[n], P[size];
};

constexpr int at(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

// The mixture by the weights w, matched in its first two moments.
inline __attribute__((always_inline)) Mode mixed(const Mode *from, const V *w) {
    Mode to;
    V d[modes][n];
    UNROLLED for (int k = 0; k < n; ++k) to.x[k] = w[0] * from[0].x[k] + w[1] * from[1].x[k] + w[2] * from[2].x[k];
    UNROLLED for (int i = 0; i < modes; ++i)
        UNROLLED for (int k = 0; k < n; ++k) d[i][k] = from[i].x[k] - to.x[k];
    UNROLLED for (int r = 0; r < n; ++r) {
        const V wd[modes] = {w[0] * d[0][r], w[1] * d[1][r], w[2] * d[2][r]};
        UNROLLED for (int c = 0; c <= r; ++c) {
            V sum = V{};
            UNROLLED for (int i = 0; i < modes; ++i) sum += w[i] * from[i].P[at(r, c)] + wd[i] * d[i][c];
            to.P[at(r, c)] = sum;
        }
    }
    return to;
}

// x <- F x, P <- F P F' + Q.
inline __attribute__((always_inline)) void predict(Mode &m, double T, double q) {
    V *x = m.x, *P = m.P;
    x[0] += T * x[1], x[2] += T * x[3];
    const V speed_x = P[1] + T * P[2], speed_y = P[8] + T * P[9];
    P[0] += T * (P[1] + speed_x) + q * T * T * T * T / 4;
    P[1] = speed_x + q * T * T * T / 2, P[2] += q * T * T;
    P[5] += T * (P[8] + speed_y) + q * T * T * T * T / 4;
    P[8] = speed_y + q * T * T * T / 2, P[9] += q * T * T;
    P[4] += T * P[7];
    P[3] += T * (P[6] + P[4]);
    P[6] += T * P[7];
}

// One measured position; returns the squared distance, and 1 / sqrt(det S) in `density`.
inline __attribute__((always_inline)) V update(Mode &m, const V *z, double r, V &density) {
    V *x = m.x, *P = m.P;
    const V a[n] = {P[0], P[1], P[3], P[6]}, over_x = over(P[0] + r), l = P[3] * over_x;
    V g[n] = {P[3], P[4], P[5], P[8]};
    UNROLLED for (int k = 0; k < n; ++k) g[k] -= l * a[k];
    const V left = g[2] + r, over_y = over(left);
    const V y_x = z[0] - x[0], y_y = (z[1] - x[2]) - l * y_x, e_x = over_x * y_x, e_y = over_y * y_y;
    UNROLLED for (int i = 0; i < n; ++i) {
        const V k_x = a[i] * over_x, k_y = g[i] * over_y;
        x[i] += a[i] * e_x + g[i] * e_y;
        UNROLLED for (int j = 0; j <= i; ++j) P[at(i, j)] -= k_x * a[j] + k_y * g[j];
    }
    density = over_root((a[0] + r) * left);
    return y_x * e_x + y_y * e_y;
}

struct Filter {
    double T, q[modes], r, transition[modes][modes];
    Mode mode[modes];
    V mu[modes], square{};
    Product likelihood;

    inline __attribute__((always_inline)) void step(const V *z, bool first, V *x) {
        V prior[modes], distance[modes], density[modes];
        Mode now[modes];
        UNROLLED for (int j = 0; j < modes; ++j) {
            prior[j] = mu[j], now[j] = mode[j];
            if (!first) {
                V w[modes];
                UNROLLED for (int i = 0; i < modes; ++i) w[i] = transition[i][j] * mu[i];
                prior[j] = w[0] + w[1] + w[2];
                const V one_over = over(prior[j]);
                for (V &share : w) share *= one_over;
                now[j] = mixed(mode, w);
                predict(now[j], T, q[j]);
            }
            distance[j] = update(now[j], z, r, density[j]);
        }
        V least = distance[0], total = V{};
        UNROLLED for (int j = 1; j < modes; ++j) least = distance[j] < least ? distance[j] : least;
        UNROLLED for (int j = 0; j < modes; ++j) mode[j] = now[j], prior[j] *= density[j] * exponential(0.5 * (least - distance[j])), total += prior[j];
        const V one_over = over(total);
        UNROLLED for (int j = 0; j < modes; ++j) mu[j] = prior[j] * one_over;
        UNROLLED for (int k = 0; k < n; ++k) x[k] = mu[0] * mode[0].x[k] + mu[1] * mode[1].x[k] + mu[2] * mode[2].x[k];
        likelihood *= total, square += least;
    }
};

void run_lanes(Filter f, long first, long used, long scans, const double *z, double *x, double *log_likelihood) {
    alignas(64) V seen[block * 2], found[block * n];
    for (long from = 0; from < scans; from += block) {
        const long count = scans - from < block ? scans - from : block;
        double *in = reinterpret_cast<double *>(seen);
        UNROLLED for (int l = 0; l < lanes; ++l) {
            const double *row = z + ((first + (l < used ? l : 0)) * scans + from) * 2;
            for (long k = 0; k < 2 * count; ++k) in[k * lanes + l] = row[k];
        }
        for (long k = 0; k < count; ++k) f.step(seen + 2 * k, from + k == 0, found + n * k);
        const double *out = reinterpret_cast<const double *>(found);
        UNROLLED for (int l = 0; l < used; ++l) {
            double *row = x + ((first + l) * scans + from) * n;
            for (long k = 0; k < n * count; ++k) row[k] = out[k * lanes + l];
        }
    }
    constexpr double log_two_pi = 1.8378770664093454836;
    UNROLLED for (int l = 0; l < used; ++l) log_likelihood[first + l] = f.likelihood.log(l) - 0.5 * f.square[l] - double(scans) * log_two_pi;
}

}  // namespace

// `x0` (tracks, 4) with the packed covariance `P0`; `z` (tracks, scans, 2), `x` (tracks, scans, 4).
extern "C" void reference_imm(long tracks, long scans, double step, const double *q, double r, const double *transition, const double *x0,
                              const double *P0, const double *z, double *x, double *log_likelihood) {
    Filter f{};
    f.T = step, f.r = r;
    std::memcpy(f.q, q, sizeof f.q), std::memcpy(f.transition, transition, sizeof f.transition);
    for (long first = 0; first < tracks; first += lanes) {
        const long used = tracks - first < lanes ? tracks - first : lanes;
        UNROLLED for (int j = 0; j < modes; ++j) {
            f.mu[j] = V{} + 1.0 / modes;
            UNROLLED for (int k = 0; k < size; ++k) f.mode[j].P[k] = V{} + P0[k];
            UNROLLED for (int l = 0; l < lanes; ++l)
                UNROLLED for (int k = 0; k < n; ++k) f.mode[j].x[k][l] = x0[(first + (l < used ? l : 0)) * n + k];
        }
        run_lanes(f, first, used, scans, z, x, log_likelihood);
    }
}
