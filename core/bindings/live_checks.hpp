// What live tracks may be given, by the rules of batches. Each check throws an error that names the argument.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "bindings/bindings.hpp"

namespace jink::inline JINK_LEVEL {

inline std::invalid_argument wrong(const std::string &what) { return std::invalid_argument(what); }

inline std::string shape_of(const Const &array) {
    std::string text = "(";
    for (std::size_t k = 0; k < array.ndim(); ++k) text += (k ? ", " : "") + std::to_string(array.shape(k));
    return text + (array.ndim() == 1 ? ",)" : ")");
}

inline void check_target(int target, int targets) {
    if (target < 0 || target >= targets)
        throw wrong("target: there is no target " + std::to_string(target) + "; expected 0 to " + std::to_string(targets - 1));
}

inline bool has_shape(const Const &array, std::initializer_list<std::size_t> shape) {
    if (array.ndim() != shape.size()) return false;
    std::size_t k = 0;
    for (const std::size_t size : shape)
        if (array.shape(k++) != size) return false;
    return true;
}

inline bool all_finite(const double *from, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k)
        if (!std::isfinite(from[k])) return false;
    return true;
}

// Is the matrix symmetric and positive definite? Its factor goes into L.
inline bool positive_definite(const double *P, int n, Vector &L) {
    L.assign(P, P + n * n);
    for (int r = 0; r < n; ++r)
        for (int q = 0; q <= r; ++q) {
            double sum = L[r * n + q];
            if (std::abs(P[r * n + q] - P[q * n + r]) > 1e-9 * std::sqrt(std::abs(P[r * n + r] * P[q * n + q]))) return false;
            for (int k = 0; k < q; ++k) sum -= L[r * n + k] * L[q * n + k];
            if (r == q && !(sum > 0.0)) return false;
            L[r * n + q] = r == q ? std::sqrt(sum) : sum / L[q * n + q];
        }
    return true;
}

// The state that a target begins with; a NaN time is that of the next scan.
inline void check_state(const Const &x, const Const &P, double time, int n) {
    const std::size_t size = n;
    if (!has_shape(x, {size})) throw wrong("x: expected shape (" + std::to_string(n) + ",), got " + shape_of(x));
    if (!has_shape(P, {size, size})) throw wrong("P: expected shape (" + std::to_string(n) + ", " + std::to_string(n) + "), got " + shape_of(P));
    if (!all_finite(x.data(), size)) throw wrong("x: has values that are not finite");
    Vector factor;
    if (!all_finite(P.data(), size * size) || !positive_definite(P.data(), n, factor)) throw wrong("P: is not symmetric and positive definite");
    if (std::isinf(time)) throw wrong("time: is infinite");
}

// Variances (columns,) or covariances (columns, columns) of one row's measurement.
inline void check_noise(const Const &R, int columns) {
    const std::size_t m = columns;
    const bool full = has_shape(R, {m, m});
    if (!full && !has_shape(R, {m}))
        throw wrong("covariance: expected (" + std::to_string(columns) + ", " + std::to_string(columns) + "), or (" + std::to_string(columns) + ",) variances, got " + shape_of(R));
    for (std::size_t r = 0; r < m; ++r) {
        const double variance = R.data()[full ? r * m + r : r];
        if (!(std::isfinite(variance) && variance > 0.0)) throw wrong("covariance: has a variance that is not positive");
    }
    Vector factor;
    if (full && (!all_finite(R.data(), m * m) || !positive_definite(R.data(), columns, factor))) throw wrong("covariance: is not positive definite");
}

inline void check_input(const Const &input, int axes) {
    if (!has_shape(input, {std::size_t(axes)})) throw wrong("input: expected shape (" + std::to_string(axes) + ",), got " + shape_of(input));
    if (!all_finite(input.data(), axes)) throw wrong("input: has values that are not finite");
}

inline void check_time(double time) {
    if (!std::isfinite(time)) throw wrong("t: expected a finite time");
}

}  // namespace jink::inline JINK_LEVEL
