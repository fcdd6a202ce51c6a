// A multilayer perceptron: y = W_L tanh(... tanh(W_1 x + b_1) ...) + b_L, evaluated for one track per lane.
#pragma once

#include <vector>

#include "number/elementary.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> JINK_INLINE T hyperbolic_tangent(T x) {
    const T e = exponential<T>(-2.0 * magnitude(x));  // never overflows
    const T y = (1.0 - e) * reciprocal(1.0 + e);
    return select<T>(x < splat<T>(0.0), -y, y);
}

inline constexpr int largest_layer = 128;

// Layer by layer: `sizes` from the inputs to the outputs; `numbers` each layer's weights row by row, then its biases.
template <class T> struct Network {
    std::vector<int> sizes;
    std::vector<T> numbers;

    int inputs() const { return sizes.front(); }
    int outputs() const { return sizes.back(); }

    void operator()(const T *x, T *y) const {
        T first[largest_layer], second[largest_layer], *from = first, *to = second;
        for (int k = 0; k < sizes[0]; ++k) from[k] = x[k];
        const T *w = numbers.data();
        for (std::size_t layer = 1; layer < sizes.size(); ++layer) {
            const int in = sizes[layer - 1], out = sizes[layer];
            const T *bias = w + in * out;
            int r = 0;
            for (; r + 4 <= out; r += 4) rows<4>(in, w + r * in, bias + r, from, to + r);
            for (; r < out; ++r) rows<1>(in, w + r * in, bias + r, from, to + r);
            for (int k = 0; k < out && layer + 1 < sizes.size(); ++k) to[k] = hyperbolic_tangent<T>(to[k]);
            w = bias + out;
            std::swap(from, to);
        }
        for (int r = 0; r < outputs(); ++r) y[r] = from[r];
    }

  private:
    // Several rows side by side: their sums do not wait for one another.
    template <int Rows> JINK_INLINE static void rows(int in, const T *w, const T *bias, const T *x, T *y) {
        T sum[Rows];
        JINK_UNROLL
        for (int r = 0; r < Rows; ++r) sum[r] = bias[r];
        for (int k = 0; k < in; ++k)
            JINK_UNROLL
            for (int r = 0; r < Rows; ++r) sum[r] = sum[r] + w[r * in + k] * x[k];
        JINK_UNROLL
        for (int r = 0; r < Rows; ++r) y[r] = sum[r];
    }
};

}  // namespace jink::inline JINK_LEVEL
