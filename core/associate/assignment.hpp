// The assignment of least total cost: each row one plot at most, each plot one row at most, a row without a plot costs nothing.
//
// Successive shortest augmenting paths with potentials (Dijkstra) over sparse edges. Jonker & Volgenant, Computing 38, 1987;
// Edmonds & Karp, J. ACM 19(2), 1972. A row of n edges costs O(edges it reaches, times log) and nothing for the rest.
#pragma once

#include <limits>
#include <queue>

#include "associate/edges.hpp"

namespace jink::inline JINK_LEVEL {

class Assignment {
  public:
    std::vector<int> plot_of, row_of;  // of each row its plot, of each plot its row, or -1
    std::vector<int> edge_of;          // of each row

    void operator()(const Edges &cost) {
        const int n = cost.rows();
        plot_of.assign(n, -1), edge_of.assign(n, -1), row_of.assign(cost.plots, -1);
        u.assign(n, 0.0), v.assign(cost.plots, 0.0);
        distance.assign(cost.plots, infinity), edge_to.assign(cost.plots, -1), from.assign(cost.plots, -1);
        closed.assign(cost.plots, 0);
        for (int i = 0; i < n; ++i)
            if (cost.begin[i] < cost.begin[i + 1]) augment(cost, i);
    }

  private:
    static constexpr double infinity = std::numeric_limits<double>::infinity();
    using Place = std::pair<double, int>;
    std::vector<double> u, v, distance;
    std::vector<char> closed;
    std::vector<int> edge_to, from, reached, done;  // of each plot: the edge and the row it was reached by

    void augment(const Edges &cost, int source) {
        std::priority_queue<Place, std::vector<Place>, std::greater<Place>> open;
        reached.clear(), done.clear();
        double best = infinity;
        int last = -1;  // the row that gives up its plot
        const auto relax = [&](int i, double base) {
            if (base - u[i] < best) best = base - u[i], last = i;
            for (int e = cost.begin[i]; e < cost.begin[i + 1]; ++e) {
                const int j = cost.plot[e];
                // Rounding must not lead a path through a plot twice.
                if (closed[j]) continue;
                const double d = base + cost.value[e] - u[i] - v[j];
                if (!(d < distance[j])) continue;
                if (distance[j] == infinity) reached.push_back(j);
                distance[j] = d, edge_to[j] = e, from[j] = i;
                open.push({d, j});
            }
        };
        relax(source, 0.0);
        int end = -1;
        while (!open.empty()) {
            const auto [d, j] = open.top();
            if (d >= best) break;
            open.pop();
            if (closed[j] || d > distance[j]) continue;
            closed[j] = 1;
            if (row_of[j] < 0) {
                best = d, end = j;
                break;
            }
            done.push_back(j);
            relax(row_of[j], d);
        }
        u[source] += best;
        for (int j : done) {
            const double ahead = best - distance[j];
            if (ahead <= 0.0) continue;
            u[row_of[j]] += ahead, v[j] -= ahead;
        }
        if (end >= 0) turn(source, end);
        else if (last != source) {
            const int freed = plot_of[last];
            plot_of[last] = edge_of[last] = -1;
            turn(source, freed);
        }
        for (int j : reached) distance[j] = infinity, closed[j] = 0;
    }

    // The path that ends at this plot changes hands.
    void turn(int source, int j) {
        for (int i = -1; i != source;) {
            i = from[j];
            const int next = plot_of[i];
            plot_of[i] = j, edge_of[i] = edge_to[j], row_of[j] = i;
            j = next;
        }
    }
};

}  // namespace jink::inline JINK_LEVEL
