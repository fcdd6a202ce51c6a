// Weigh by a network instead of Bayes' rule: scores of all modes from their last weights and how the measurement fits each of them;
// the best k share the estimate by their softmax. Choi, Samal & Ahn, 2001, equation 8, "mode-based".
#pragma once

#include "scan/track.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> class Scores {
  public:
    explicit Scores(const Composition<T> &composition) : c(composition) {
        const AdaptDeclaration &d = c.declared.scores;
        if (d.sizes.empty()) return;
        const int inputs = d.sizes.front();
        numbers = Composition<T>::numbers(d.numbers);
        keep = int(d.numbers[2 * inputs]);
        network.sizes = d.sizes;
        network.numbers.assign(numbers.begin() + 2 * inputs + 1, numbers.end());
    }
    bool active() const { return keep > 0; }

    // Inputs: each mode's weight before the measurement, then log(NIS/m + 0.01) of each, m the number of measured components.
    void operator()(TrackState<T> &s, const T *prior, const Innovation<T> *innovations, T measured) const {
        const int m = c.count;
        T x[largest_layer], score[largest_layer];
        const T zero = splat<T>(0.0), over = 1.0 / larger<T>(measured, splat<T>(1.0));
        for (int j = 0; j < m; ++j) x[j] = prior[j], x[m + j] = logarithm<T>(innovations[j].nis * over + 0.01);
        for (int k = 0; k < network.inputs(); ++k) x[k] = (x[k] - numbers[2 * k]) / numbers[2 * k + 1];
        network(x, score);
        T most = score[0], sum = zero;
        for (int j = 1; j < m; ++j) most = larger<T>(most, score[j]);
        for (int j = 0; j < m; ++j) {
            T above = zero;  // how many score higher, or the same and come first
            for (int i = 0; i < m; ++i) {
                const Mask<T> higher = i < j ? inverse(score[i] < score[j]) : score[i] > score[j];
                above = above + select<T>(higher, splat<T>(1.0), zero);
            }
            x[j] = select<T>(above < splat<T>(keep), exponential<T>(score[j] - most), zero);
            sum = sum + x[j];
        }
        for (int j = 0; j < m; ++j) s.probability[j] = select<T>(measured > zero, x[j] / sum, prior[j]);
    }

  private:
    const Composition<T> &c;
    std::vector<T> numbers;
    Network<T> network;
    int keep = 0;
};

}  // namespace jink::inline JINK_LEVEL
