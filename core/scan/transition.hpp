// Mode transition probabilities over an elapsed time.
#pragma once

#include <vector>

#include "number/elementary.hpp"

namespace jink::inline JINK_LEVEL {

// Per scan: the matrix itself, whatever the step, but nothing at all over no time.
// Continuous: exp(G t) of a generator G, by uniformisation: with rate q and B = I + G/q, both without a negative entry,
//     exp(G t) = sum_k e^(-qt) (qt)^k / k!  B^k,   qt <= 1/2,   and squaring for longer times.
// No subtraction anywhere: probabilities stay probabilities. Ross, Introduction to Probability Models, section 6.8.
template <class T> class Transition {
  public:
    Transition() = default;
    Transition(int modes, bool continuous, const std::vector<T> &matrix) : m(modes), continuous_time(continuous), pi(matrix) {
        if (!continuous_time) return;
        rate = splat<T>(1e-300);
        for (int i = 0; i < m; ++i) rate = larger<T>(rate, -matrix[i * m + i]);
        powers.assign(terms * m * m, splat<T>(0.0));
        for (int i = 0; i < m; ++i) powers[i * m + i] = splat<T>(1.0);
        std::vector<T> B(m * m);
        for (int i = 0; i < m * m; ++i) B[i] = matrix[i] / rate + (i % (m + 1) == 0 ? 1.0 : 0.0);
        for (int k = 1; k < terms; ++k) {
            multiply(&powers[(k - 1) * m * m], B.data(), &powers[k * m * m]);
            for (int i = 0; i < m * m; ++i) powers[k * m * m + i] = powers[k * m * m + i] * (1.0 / k);
        }
    }

    // `scratch` has room for a matrix.
    void over(T dt, T *out, T *scratch) const {
        if (!continuous_time) {
            const Mask<T> elapsed = dt > splat<T>(0.0);
            for (int i = 0; i < m * m; ++i)
                out[i] = select<T>(elapsed, pi[i], splat<T>(i % (m + 1) == 0 ? 1.0 : 0.0));
            return;
        }
        T t = smaller<T>(rate * dt, splat<T>(1e300)), halvings = splat<T>(0.0);
        int squarings = 0;
        for (; any(t > splat<T>(0.5)); ++squarings) {
            const Mask<T> longer = t > splat<T>(0.5);
            t = select<T>(longer, 0.5 * t, t), halvings = select<T>(longer, halvings + 1.0, halvings);
        }
        const bool many = squarings > most_squarings;
        const T decay = exponential<T>(-t);
        for (int i = 0; i < m * m; ++i) {
            T sum = powers[(terms - 1) * m * m + i];
            for (int k = terms - 2; k >= 0; --k) sum = sum * t + powers[k * m * m + i];
            out[i] = sum * decay;
        }
        while (squarings-- > 0) {
            multiply(out, out, scratch);
            if (many) normalise(scratch);
            for (int i = 0; i < m * m; ++i) out[i] = select<T>(halvings > splat<T>(squarings), scratch[i], out[i]);
        }
    }

  private:
    static constexpr int terms = 15;
    // A squaring doubles the rounding error of a row's sum; of more than so many it would become seen.
    static constexpr int most_squarings = 16;
    int m = 0;
    bool continuous_time = false;
    T rate{};
    std::vector<T> pi, powers;

    void normalise(T *rows) const {
        for (int i = 0; i < m; ++i) {
            T sum = rows[i * m];
            for (int j = 1; j < m; ++j) sum = sum + rows[i * m + j];
            for (int j = 0; j < m; ++j) rows[i * m + j] = rows[i * m + j] / sum;
        }
    }

    void multiply(const T *a, const T *b, T *out) const {
        for (int i = 0; i < m; ++i)
            for (int j = 0; j < m; ++j) {
                T sum = splat<T>(0.0);
                for (int k = 0; k < m; ++k) sum = sum + a[i * m + k] * b[k * m + j];
                out[i * m + j] = sum;
            }
    }
};

}  // namespace jink::inline JINK_LEVEL
