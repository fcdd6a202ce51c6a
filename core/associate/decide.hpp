// From the weights of a scan's edges to what each track takes in: the rules of association.
//
//   marginal  marginals by belief propagation, then ownership among established tracks
//   jpda      exact marginals where the cluster is small enough, else belief propagation
//   pda       each track by itself: p_ij = psi_ij / (1 + sum psi)
//   gnn       one optimal assignment of all tracks, by log-likelihood ratio
//   nearest   each track takes the nearest plot in its gate
#pragma once

#include "associate/assignment.hpp"
#include "associate/marginals.hpp"

namespace jink::inline JINK_LEVEL {

enum class Association { marginal, jpda, pda, gnn, nearest };

// How fast a track is, and how surely.
struct Speed {
    double x = 0.0, y = 0.0, xx = 1.0, xy = 0.0, yy = 1.0;

    // Squared distance between two by both covariances.
    double apart(const Speed &other) const {
        const double dx = x - other.x, dy = y - other.y, a = xx + other.xx, b = xy + other.xy, d = yy + other.yy;
        return (d * dx * dx - 2.0 * b * dx * dy + a * dy * dy) / (a * d - b * b);
    }
};

// ratio: log(Pd l / lambda) of each edge, the gain in likelihood of "the plot is the track's, which exists" over "it is not".
struct Weighing {
    Edges ratio;
    std::vector<double> distance2;   // of each edge
    std::vector<double> existence;   // of each row, predicted
    std::vector<double> detection;   // of each row
    std::vector<Speed> speed;        // of each row; empty: all are alike
    std::vector<double> unseen;      // of each row: probability that a track that exists has no plot, 1 - Pd, or 1 if nobody looked
};

class Decide {
  public:
    Marginals found;  // what was decided: of each edge, row and plot
    bool inexact = false;  // some cluster was too large for exact marginals

    // Tracks above this existence own the plots that the optimal assignment gives them; above 1 none does.
    double established = 0.5;
    // Share that a track keeps of its marginal for a plot that another one owns.
    double left = 0.0;
    // Only tracks whose velocities are nearer than this (squared distance) own plots against each other: others part by themselves.
    double abreast = INFINITY;

    // With `weigh_all`, of `marginal`: the logarithm of the sum over all assignments of the product of their weights; else NaN.
    bool weigh_all = false;
    double log_total = NAN;

    void operator()(Association how, const Weighing &w) {
        inexact = false, log_total = NAN;
        beliefs.weigh_all = weigh_all;
        psi = w.ratio;
        found.clear(psi);
        by.take(psi);
        if (how == Association::gnn || how == Association::nearest) return hard(how, w);
        for (int i = 0; i < psi.rows(); ++i) {
            const double odds = w.existence[i] / (1.0 - w.existence[i] + w.existence[i] * w.unseen[i]);
            for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) psi.value[e] = odds * std::exp(std::min(w.ratio.value[e], 600.0));
        }
        if (how == Association::pda) return apart();
        if (how == Association::marginal) set_aside();
        clusters.take(psi);
        beliefs.prepare(psi, by);
        for (int k = 0; k < clusters.count(); ++k) {
            const int *rows = &clusters.row[clusters.begin[k]], n = clusters.begin[k + 1] - clusters.begin[k];
            if (how == Association::jpda && exact(psi, rows, n, found)) continue;
            inexact = inexact || (how == Association::jpda);
            beliefs(psi, rows, n, found);
        }
        if (how == Association::marginal) {
            log_total = weigh_all ? beliefs.log_total : NAN;
            follow();
            if (established < 1.0) own(w);
        }
    }

    // Rows whose every weight is below this share plots with others without being felt by them; 0: all are felt.
    double slight = 1e-2;

    const Edges &weights() const { return psi; }
    const Clusters &parts() const { return clusters; }

  private:
    Edges psi, cost, whole;
    std::vector<int> slights, edge_at;
    ByPlot by;
    Clusters clusters;
    BeliefPropagation beliefs;
    ExactMarginals exact;
    Assignment assignment;
    std::vector<int> row_of, edge_of;

    // The slight rows leave the clusters, which become small, and take what the others leave: p_ij = psi_ij nu_j / (1 + sum psi nu).
    void set_aside() {
        whole = psi, edge_at.clear(), slights.clear();
        psi.clear(whole.plots);
        for (int i = 0; i < whole.rows(); ++i) {
            const auto from = whole.value.begin() + whole.begin[i], to = whole.value.begin() + whole.begin[i + 1];
            if (from != to && *std::max_element(from, to) < slight) {
                slights.push_back(i);
            } else {
                for (int e = whole.begin[i]; e < whole.begin[i + 1]; ++e)
                    psi.plot.push_back(whole.plot[e]), psi.value.push_back(whole.value[e]), edge_at.push_back(e);
            }
            psi.begin.push_back(psi.count());
        }
        by.take(psi);
        found.clear(psi);
    }

    void follow() {
        std::vector<double> hit(whole.count(), 0.0);
        for (int e = 0; e < psi.count(); ++e) hit[edge_at[e]] = found.hit[e];
        for (int i : slights) {
            double sum = 1.0;
            for (int e = whole.begin[i]; e < whole.begin[i + 1]; ++e) sum += whole.value[e] * found.lone[whole.plot[e]];
            for (int e = whole.begin[i]; e < whole.begin[i + 1]; ++e) hit[e] = whole.value[e] * found.lone[whole.plot[e]] / sum;
            found.miss[i] = 1.0 / sum;
            if (weigh_all) log_total += std::log(sum);
        }
        found.hit.swap(hit);
        std::swap(psi, whole);
    }

    void apart() {
        for (int i = 0; i < psi.rows(); ++i) {
            double sum = 1.0;
            for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) sum += psi.value[e];
            for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) {
                found.hit[e] = psi.value[e] / sum;
                found.lone[psi.plot[e]] *= 1.0 - found.hit[e];
            }
            found.miss[i] = 1.0 / sum;
        }
    }

    // Each row takes one plot at most, and it is believed.
    void hard(Association how, const Weighing &w) {
        if (how == Association::gnn) {
            cost.clear(psi.plots);
            row_of.clear(), edge_of.clear();
            for (int i = 0; i < psi.rows(); ++i) {
                for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) {
                    const double gain = w.ratio.value[e] - std::log(w.unseen[i]);
                    if (gain > 0.0) cost.plot.push_back(psi.plot[e]), cost.value.push_back(-gain), edge_of.push_back(e);
                }
                cost.begin.push_back(int(cost.plot.size()));
            }
            assignment(cost);
            for (int i = 0; i < psi.rows(); ++i)
                if (assignment.edge_of[i] >= 0) take(i, edge_of[assignment.edge_of[i]]);
            return;
        }
        for (int i = 0; i < psi.rows(); ++i) {
            int best = -1;
            for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e)
                if (best < 0 || w.distance2[e] < w.distance2[best]) best = e;
            if (best >= 0) take(i, best);
        }
    }
    void take(int i, int e) { found.hit[e] = 1.0, found.miss[i] = 0.0, found.lone[psi.plot[e]] = 0.0; }

    // Ownership: a plot that the optimal assignment of the established tracks gives to one of them is no other one's. Clutter stays
    // soft, and tracks side by side do not exchange their plots by halves, which would pull them together.
    void own(const Weighing &w) {
        cost.clear(psi.plots);
        row_of.clear();
        for (int k = 0; k < clusters.count(); ++k) {
            int seniors = 0;
            for (int r = clusters.begin[k]; r < clusters.begin[k + 1]; ++r) seniors += w.existence[clusters.row[r]] > established;
            if (seniors < 2) continue;
            for (int r = clusters.begin[k]; r < clusters.begin[k + 1]; ++r) {
                const int i = clusters.row[r];
                if (!(w.existence[i] > established)) continue;
                for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e)
                    if (psi.value[e] > 1.0) cost.plot.push_back(psi.plot[e]), cost.value.push_back(-std::log(psi.value[e]));
                cost.begin.push_back(int(cost.plot.size())), row_of.push_back(i);
            }
        }
        if (row_of.empty()) return;
        assignment(cost);
        for (int k = 0; k < int(row_of.size()); ++k) {
            const int i = row_of[k];
            double sum = found.miss[i];
            for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) {
                const int owner = assignment.row_of[psi.plot[e]];
                if (owner >= 0 && owner != k && (w.speed.empty() || w.speed[i].apart(w.speed[row_of[owner]]) < abreast)) found.hit[e] *= left;
                sum += found.hit[e];
            }
            if (!(sum > 0.0)) continue;
            found.miss[i] /= sum;
            for (int e = psi.begin[i]; e < psi.begin[i + 1]; ++e) found.hit[e] /= sum;
        }
    }
};

}  // namespace jink::inline JINK_LEVEL
