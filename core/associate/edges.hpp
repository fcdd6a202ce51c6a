// Which plots may be which tracks': a sparse matrix by rows (tracks), its columns (plots), and the clusters it falls into.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace jink::inline JINK_LEVEL {

// Row i owns the edges begin[i] .. begin[i + 1]; the plots of a row are in increasing order.
struct Edges {
    std::vector<int> begin{0};
    std::vector<int> plot;
    std::vector<double> value;
    int plots = 0;

    int rows() const { return int(begin.size()) - 1; }
    int count() const { return int(plot.size()); }
    void clear(int plots_) { begin.assign(1, 0), plot.clear(), value.clear(), plots = plots_; }
};

// The same edges by plot: `edge` and `row` of each, plot after plot.
struct ByPlot {
    std::vector<int> begin, edge, row;

    void take(const Edges &edges) {
        begin.assign(edges.plots + 1, 0), edge.resize(edges.count()), row.resize(edges.count());
        for (int j : edges.plot) ++begin[j + 1];
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        at.assign(begin.begin(), begin.end() - 1);
        for (int i = 0; i < edges.rows(); ++i)
            for (int e = edges.begin[i]; e < edges.begin[i + 1]; ++e) {
                const int to = at[edges.plot[e]]++;
                edge[to] = e, row[to] = i;
            }
    }

  private:
    std::vector<int> at;
};

// Rows that share plots, directly or through others: cluster k has the rows begin[k] .. begin[k + 1] of `row`. Rows without a
// plot are in none. Union-find with path halving. Tarjan, J. ACM 22(2), 1975.
struct Clusters {
    std::vector<int> begin, row;

    int count() const { return int(begin.size()) - 1; }

    void take(const Edges &edges) {
        const int n = edges.rows();
        parent.resize(n), first.assign(edges.plots, -1);
        std::iota(parent.begin(), parent.end(), 0);
        for (int i = 0; i < n; ++i)
            for (int e = edges.begin[i]; e < edges.begin[i + 1]; ++e) {
                int &owner = first[edges.plot[e]];
                if (owner < 0) owner = i;
                else unite(owner, i);
            }
        // A cluster is numbered by its lowest row, so that the order of edges does not matter.
        size.assign(n + 1, 0);
        for (int i = 0; i < n; ++i)
            if (edges.begin[i] < edges.begin[i + 1]) ++size[root(i)];
        begin.assign(1, 0), place.assign(n, 0);
        for (int i = 0; i < n; ++i)
            if (size[i] > 0) place[i] = begin.back(), begin.push_back(begin.back() + size[i]);
        row.resize(begin.back());
        for (int i = 0; i < n; ++i)
            if (edges.begin[i] < edges.begin[i + 1]) row[place[root(i)]++] = i;
    }

  private:
    std::vector<int> parent, first, size, place;

    int root(int i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    }
    void unite(int a, int b) {
        a = root(a), b = root(b);
        if (a != b) parent[std::max(a, b)] = std::min(a, b);
    }
};

}  // namespace jink::inline JINK_LEVEL
