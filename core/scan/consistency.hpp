// How well the innovation fits what was expected, over all modes (or all pairs of modes, where those are kept apart).
#pragma once

#include <vector>

#include "scan/update.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> struct Hypotheses {
    int count;
    const T *prior;
    const Innovation<T> *innovations;
};

// NIS of the innovation moment-matched over the modes. What cannot be may not have been run, and says nothing.
template <class T> T matched_nis(const Hypotheses<T> &h, int rows, const Mask<T> *present) {
    T y[largest_measurement], S[packed_size(largest_measurement)], L[packed_size(largest_measurement)];
    const T zero = splat<T>(0.0);
    const auto of = [&](int j, T value) { return select<T>(h.prior[j] > zero, h.prior[j] * value, zero); };
    for (int r = 0; r < rows; ++r) {
        y[r] = zero;
        for (int j = 0; j < h.count; ++j) y[r] = y[r] + of(j, h.innovations[j].y[r]);
    }
    for (int r = 0; r < rows; ++r)
        for (int q = 0; q <= r; ++q) {
            T sum = zero;
            for (int j = 0; j < h.count; ++j) {
                const Innovation<T> &v = h.innovations[j];
                sum = sum + of(j, v.joint[packed(r, q)] + (v.y[r] - y[r]) * (v.y[q] - y[q]));
            }
            S[packed(r, q)] = sum;
        }
    cholesky<T>(rows, S, L);
    solve_lower<T>(rows, L, y);
    T nis = zero;
    for (int r = 0; r < rows; ++r) nis = nis + select<T>(present[r], y[r] * y[r], zero);
    return nis;
}

// Rosenblatt's transform of the measurement under the mixture: independent and uniform if the filter is consistent.
template <class T> void transform(const Hypotheses<T> &h, int rows, const Mask<T> *present, std::vector<T> &log_prior, T *pit) {
    log_prior.resize(h.count);
    for (int j = 0; j < h.count; ++j) log_prior[j] = logarithm<T>(larger<T>(h.prior[j], splat<T>(1e-300)));
    for (int r = 0; r < rows; ++r) {
        T most = log_prior[0], sum = splat<T>(0.0), below = sum;
        for (int j = 1; j < h.count; ++j) most = larger<T>(most, log_prior[j]);
        for (int j = 0; j < h.count; ++j) {
            const Innovation<T> &v = h.innovations[j];
            const T w = exponential<T>(log_prior[j] - most), u = v.e[r] / square_root(v.S[r]);
            const Mask<T> possible = h.prior[j] > splat<T>(0.0);
            sum = sum + select<T>(possible, w, splat<T>(0.0)), below = below + select<T>(possible, w * normal_cdf<T>(u), splat<T>(0.0));
            log_prior[j] = select<T>(possible, log_prior[j] - 0.5 * (u * u + logarithm<T>(v.S[r])), splat<T>(-1e300));
        }
        pit[r] = select<T>(present[r], below / sum, nan_of<T>());
    }
}

}  // namespace jink::inline JINK_LEVEL
