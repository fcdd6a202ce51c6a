// The network of a correction in the plane (plane_corrector.hpp), in single precision: its answers need no more, and twice as many fit a register.
//
// h+- = max(0, A (u, a) + b +- B (w, o)); the even answers are V (h+ + h-)/2 + v, the odd ones W (h+ - h-)/2. It remembers a, which stays as it
// is when the plane is mirrored, and o, which changes sign: after a scan a is l a + (1 - l) clip(G (h+ + h-)/2 + g) and o likewise by K.
#pragma once

#include <vector>

#include "number/number.hpp"

namespace jink::inline JINK_LEVEL {

inline constexpr int plane_answers = 5, plane_block = 8;  // units side by side: their sums do not wait for one another
inline constexpr int plane_kept = 32;                     // quantities of each kind that are remembered, at most
inline constexpr double plane_bound = 3.0;                // of what is remembered

// A, B, b, V, v, W; l, G, g, K.
constexpr int plane_weights(int even, int odd, int hidden, int kept) {
    return hidden * (even + odd + 2 * kept + 1) + 3 * (hidden + 1) + 2 * hidden + 2 * kept * (hidden + 1);
}

template <class T> class PlaneNetwork {
  public:
    using S = Single<T>;

    PlaneNetwork() = default;
    PlaneNetwork(int even_inputs, int odd_inputs, int hidden, int kept_, const double *from)
        : even(even_inputs + kept_), odd(odd_inputs + kept_), kept(kept_), blocks((hidden + plane_block - 1) / plane_block) {
        const double *A = from, *B = A + hidden * even, *b = B + hidden * odd, *V = b + hidden, *v = V + 3 * hidden, *W = v + 3;
        const double *l = W + 2 * hidden, *G = l + kept, *g = G + kept * hidden, *K = g + kept;
        const auto row = [&](int block, const double *values, int step, double factor) {
            for (int r = block * plane_block; r < (block + 1) * plane_block; ++r) weights.push_back(r < hidden ? float(factor * values[r * step]) : 0.0f);
        };
        for (int block = 0; block < blocks; ++block) {
            for (int i = 0; i < even; ++i) row(block, A + i, even, 1.0);
            for (int i = 0; i < odd; ++i) row(block, B + i, odd, 1.0);
            row(block, b, 1, 1.0);
            for (int k = 0; k < 3; ++k) row(block, V + k * hidden, 1, 0.5);
            for (int k = 0; k < kept; ++k) row(block, G + k * hidden, 1, 0.5);
            for (int k = 0; k < 2; ++k) row(block, W + k * hidden, 1, 0.5);
            for (int k = 0; k < kept; ++k) row(block, K + k * hidden, 1, 0.5);
        }
        offsets.assign(v, v + 3), offsets.insert(offsets.end(), g, g + kept), keep.assign(l, l + kept);
    }

    // u, w: inputs, then what is remembered, which is set to what the next scan remembers; y: even and odd answers by turns.
    void operator()(S *u, S *w, S *y) const {
        S total[3 + plane_kept], difference[2 + plane_kept];
        for (int k = 0; k < 3 + kept; ++k) total[k] = splat<S>(offsets[k]);
        for (int k = 0; k < 2 + kept; ++k) difference[k] = splat<S>(0.0);
        const float *from = weights.data();
        for (int block = 0; block < blocks; ++block) from = units(from, u, w, total, difference);
        y[0] = total[0], y[1] = difference[0], y[2] = total[1], y[3] = difference[1], y[4] = total[2];
        for (int k = 0; k < kept; ++k) {
            recall(keep[k], total[3 + k], u[even - kept + k]);
            recall(keep[k], difference[2 + k], w[odd - kept + k]);
        }
    }

  private:
    int even = 0, odd = 0, kept = 0, blocks = 0;
    std::vector<float> weights, offsets, keep;  // weights: of one block of units after the other, as operator() takes them

    static void recall(float share, S said, S &held) {
        const S bounded = larger<S>(smaller<S>(said, splat<S>(plane_bound)), splat<S>(-plane_bound));
        held = bounded + share * (held - bounded);  // rounded alike with and without lanes
    }

    JINK_INLINE const float *units(const float *from, const S *u, const S *w, S *total, S *difference) const {
        const S zero = splat<S>(0.0);
        S s[plane_block], t[plane_block];
        JINK_UNROLL
        for (int r = 0; r < plane_block; ++r) s[r] = t[r] = zero;
        for (int i = 0; i < even; ++i, from += plane_block)
            JINK_UNROLL
            for (int r = 0; r < plane_block; ++r) s[r] = s[r] + from[r] * u[i];
        for (int i = 0; i < odd; ++i, from += plane_block)
            JINK_UNROLL
            for (int r = 0; r < plane_block; ++r) t[r] = t[r] + from[r] * w[i];
        JINK_UNROLL
        for (int r = 0; r < plane_block; ++r) {
            const S level = s[r] + from[r], up = larger<S>(level + t[r], zero), down = larger<S>(level - t[r], zero);
            s[r] = up + down, t[r] = up - down;
        }
        from = added(from + plane_block, 3 + kept, s, total);
        return added(from, 2 + kept, t, difference);
    }

    JINK_INLINE static const float *added(const float *from, int count, const S *h, S *to) {
        for (int k = 0; k < count; ++k, from += plane_block) {
            S sum = to[k];
            JINK_UNROLL
            for (int r = 0; r < plane_block; ++r) sum = sum + from[r] * h[r];
            to[k] = sum;
        }
        return from;
    }
};

}  // namespace jink::inline JINK_LEVEL
