// How probable it is that a plot is a track's, over all assignments that give a plot to one track at most and a track one plot at most.
//
// psi[e] is the weight of an edge relative to "the track has no plot" and "the plot is nobody's", both of weight one.
#pragma once

#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "associate/edges.hpp"

namespace jink::inline JINK_LEVEL {

struct Marginals {
    std::vector<double> hit;   // of each edge
    std::vector<double> miss;  // of each row: it has no plot
    std::vector<double> lone;  // of each plot: it is of no row

    void clear(const Edges &psi) { hit.assign(psi.count(), 0.0), miss.assign(psi.rows(), 1.0), lone.assign(psi.plots, 1.0); }
};

// Loopy belief propagation. Williams & Lau, IEEE Trans. AES 50(4), 2014:
//     mu_ij = psi_ij / (1 + sum_{j' != j} psi_ij' nu_j'i),    nu_ji = 1 / (1 + sum_{i' != i} mu_i'j).
// Sums without one term are made of those before and after it: nothing is subtracted, so a dominant term does no harm.
class BeliefPropagation {
  public:
    double tolerance = 1e-4;  // largest change of a message in the last sweep, relative to the message and to a thousandth
    int sweeps = 200;
    // Logarithm of the sum over all assignments of the product of their weights (Bethe's approximation, exact on trees), added up
    // over the clusters since `prepare`: sum_i log(1 + sum_j psi nu) + sum_j log(1 + sum_i mu) - sum_ij log(1 + mu nu).
    bool weigh_all = false;
    double log_total = 0.0;

    void prepare(const Edges &psi, const ByPlot &by) { mu.assign(psi.count(), 0.0), nu.assign(psi.count(), 1.0), index = &by, log_total = 0.0; }

    // Of the rows of one cluster; returns how many sweeps it took.
    int operator()(const Edges &psi, const int *rows, int n, Marginals &out) {
        columns.clear();
        for (int k = 0; k < n; ++k)
            for (int e = psi.begin[rows[k]]; e < psi.begin[rows[k] + 1]; ++e) columns.push_back(psi.plot[e]);
        std::sort(columns.begin(), columns.end());
        columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
        int sweep = 0;
        for (bool moving = true; sweep < sweeps && moving; ++sweep) {
            moving = false;
            for (int k = 0; k < n; ++k) moving = from_row(psi, rows[k]) || moving;
            // One row alone is exact at once.
            if (n == 1) break;
            for (int j : columns) from_plot(j);
        }
        finish(psi, rows, n, out);
        return sweep;
    }

  private:
    std::vector<double> mu, nu, before;
    std::vector<int> columns;
    const ByPlot *index = nullptr;

    // True if a message of the row has changed by more than the tolerance.
    bool from_row(const Edges &psi, int i) {
        const int from = psi.begin[i], to = psi.begin[i + 1];
        bool moving = false;
        double sum = 1.0;
        before.resize(to - from);
        for (int e = from; e < to; ++e) before[e - from] = sum, sum += psi.value[e] * nu[e];
        sum = 0.0;
        for (int e = to - 1; e >= from; --e) {
            const double message = psi.value[e] / (before[e - from] + sum);
            moving = moving || std::abs(message - mu[e]) > tolerance * (message + 1e-3);
            mu[e] = message;
            sum += psi.value[e] * nu[e];
        }
        return moving;
    }

    void from_plot(int j) {
        const int from = index->begin[j], to = index->begin[j + 1];
        double sum = 1.0;
        before.resize(to - from);
        for (int k = from; k < to; ++k) before[k - from] = sum, sum += mu[index->edge[k]];
        sum = 0.0;
        for (int k = to - 1; k >= from; --k) {
            nu[index->edge[k]] = 1.0 / (before[k - from] + sum);
            sum += mu[index->edge[k]];
        }
    }

    void finish(const Edges &psi, const int *rows, int n, Marginals &out) {
        for (int k = 0; k < n; ++k) {
            const int i = rows[k];
            double sum = 1.0;
            for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) sum += psi.value[e] * nu[e];
            for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) out.hit[e] = psi.value[e] * nu[e] / sum;
            out.miss[i] = 1.0 / sum;
            if (weigh_all) {
                log_total += std::log(sum);
                for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) log_total -= std::log1p(mu[e] * nu[e]);
            }
        }
        for (int j : columns) {
            double sum = 1.0;
            for (int k = index->begin[j]; k < index->begin[j + 1]; ++k) sum += mu[index->edge[k]];
            out.lone[j] = 1.0 / sum;
            if (weigh_all) log_total += std::log(sum);
        }
    }
};

// The same exactly (JPDA), by dynamic programming over the rows: a state is the set of plots taken that later rows could want.
// Fortmann, Bar-Shalom & Scheffe, IEEE J. Oceanic Eng. 8(3), 1983. False, and nothing done, if it takes more than `most` states.
class ExactMarginals {
  public:
    int most = 4096;

    bool operator()(const Edges &psi, const int *rows, int n, Marginals &out) {
        if (!number_plots(psi, rows, n)) return false;
        std::vector<Layer> forward(n + 1), backward(n + 1);
        forward[0][0] = backward[n][0] = 1.0;
        for (int k = 0; k < n; ++k) {
            for (const auto &[mask, weight] : forward[k])
                each_choice(psi, rows[k], mask, [&](std::uint64_t taken, double value, int) { forward[k + 1][taken & wanted[k + 1]] += weight * value; });
            if (int(forward[k + 1].size()) > most) return false;
        }
        for (int k = n - 1; k >= 0; --k)
            for (const auto &[mask, weight] : forward[k]) {
                double sum = 0.0;
                each_choice(psi, rows[k], mask, [&](std::uint64_t taken, double value, int) { sum += value * backward[k + 1][taken & wanted[k + 1]]; });
                backward[k][mask] = sum;
            }
        const double total = backward[0][0];
        for (int k = 0; k < n; ++k) {
            out.miss[rows[k]] = 0.0;
            for (const auto &[mask, weight] : forward[k])
                each_choice(psi, rows[k], mask, [&](std::uint64_t taken, double value, int e) {
                    const double p = weight * value * backward[k + 1][taken & wanted[k + 1]] / total;
                    if (e < 0) out.miss[rows[k]] += p;
                    else out.hit[e] += p;
                });
        }
        for (int j : columns) out.lone[j] = 1.0;
        for (int k = 0; k < n; ++k)
            for (int e = psi.begin[rows[k]]; e < psi.begin[rows[k] + 1]; ++e) out.lone[psi.plot[e]] -= out.hit[e];
        for (int j : columns) out.lone[j] = std::max(out.lone[j], 0.0);
        return true;
    }

  private:
    using Layer = std::unordered_map<std::uint64_t, double>;
    std::vector<int> columns;
    std::vector<std::uint64_t> wanted;  // the plots that row k or a later one could take

    bool number_plots(const Edges &psi, const int *rows, int n) {
        columns.clear();
        for (int k = 0; k < n; ++k)
            for (int e = psi.begin[rows[k]]; e < psi.begin[rows[k] + 1]; ++e) columns.push_back(psi.plot[e]);
        std::sort(columns.begin(), columns.end());
        columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
        if (columns.size() > 64) return false;
        wanted.assign(n + 1, 0);
        for (int k = n - 1; k >= 0; --k) {
            wanted[k] = wanted[k + 1];
            for (int e = psi.begin[rows[k]]; e < psi.begin[rows[k] + 1]; ++e) wanted[k] |= bit(psi.plot[e]);
        }
        return true;
    }

    std::uint64_t bit(int plot) const {
        return std::uint64_t(1) << (std::lower_bound(columns.begin(), columns.end(), plot) - columns.begin());
    }

    template <class F> void each_choice(const Edges &psi, int i, std::uint64_t mask, F choose) const {
        choose(mask, 1.0, -1);
        for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) {
            const std::uint64_t b = bit(psi.plot[e]);
            if (!(mask & b)) choose(mask | b, psi.value[e], e);
        }
    }
};

}  // namespace jink::inline JINK_LEVEL
