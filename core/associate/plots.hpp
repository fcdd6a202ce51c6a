// The plots of one scan, sorted so that neither results nor time depend on the order in which they came, on a grid of cells.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "scan/step.hpp"

namespace jink::inline JINK_LEVEL {

// What a scan brings, row by row. Null where not given.
struct PlotRows {
    int count = 0, columns = 0;
    const double *z = nullptr;
    const double *noise = nullptr;       // variances, or covariances if full
    bool full_noise = false;
    const double *unit = nullptr;        // density of plots in the measurement space over that in the plane, at each plot
    const std::int64_t *code = nullptr;  // identity, -1 where it says none
    const double *time = nullptr;        // of each plot, where the scan is no instant
    const std::int64_t *waiting = nullptr;  // 1: of the next sector; tracks may take it, but it begins none yet
};

class Plots {
  public:
    int count = 0;
    std::vector<int> row;                    // of each plot in the order of this class, where it came from
    std::vector<Fix<double>> fix;            // measured position
    std::vector<double> z, noise;
    std::vector<double> log_unit;            // logarithm of the unit of each
    std::vector<double> time;                // empty where all have the scan's
    double earliest = 0.0, latest = 0.0;     // of these times
    std::vector<std::int64_t> code;
    std::vector<char> waiting;
    int columns = 0, terms = 0;
    bool full = false;
    double largest[3] = {};                  // variance of a position, over all plots

    // `measured` turns rows of z into positions; rows without one are left out and counted.
    int take(const PlotRows &rows, const std::vector<Fix<double>> &positions) {
        row.clear();
        for (int j = 0; j < rows.count; ++j)
            if (positions[j].position && std::isfinite(positions[j].p[0]) && std::isfinite(positions[j].p[1])) row.push_back(j);
        count = int(row.size());
        spread(positions);
        keys.resize(count);
        for (int k = 0; k < count; ++k) keys[k] = {cell_of(positions[row[k]].p), row[k]};
        const auto before = [&](const std::pair<int, int> &a, const std::pair<int, int> &b) {
            if (a.first != b.first) return a.first < b.first;
            const double *za = rows.z + std::int64_t(a.second) * rows.columns, *zb = rows.z + std::int64_t(b.second) * rows.columns;
            if (std::lexicographical_compare(za, za + rows.columns, zb, zb + rows.columns)) return true;
            return !std::lexicographical_compare(zb, zb + rows.columns, za, za + rows.columns) && a.second < b.second;
        };
        std::sort(keys.begin(), keys.end(), before);
        for (int k = 0; k < count; ++k) row[k] = keys[k].second;
        copy(rows, positions);
        start.assign(std::size_t(across) * down + 1, 0);
        for (const auto &f : fix) ++start[cell_of(f.p) + 1];
        std::partial_sum(start.begin(), start.end(), start.begin());
        return rows.count - count;
    }

    // Calls f(plot) for the plots within the box.
    template <class F> void within(const double *low, const double *high, F f) const {
        if (!count || !(low[0] <= high[0]) || !(low[1] <= high[1])) return;
        const int left = column_of(low[0]), right = column_of(high[0]), bottom = line_of(low[1]), top = line_of(high[1]);
        for (int y = bottom; y <= top; ++y)
            for (int j = start[y * across + left]; j < start[y * across + right + 1]; ++j) {
                const double *p = fix[j].p;
                if (p[0] >= low[0] && p[0] <= high[0] && p[1] >= low[1] && p[1] <= high[1]) f(j);
            }
    }

  private:
    double corner[2] = {}, over = 1.0;
    int across = 1, down = 1;
    std::vector<int> start;
    std::vector<std::pair<int, int>> keys;  // cell and row

    void spread(const std::vector<Fix<double>> &positions) {
        double low[2] = {0.0, 0.0}, high[2] = {0.0, 0.0};
        for (int k = 0; k < count; ++k)
            for (int a = 0; a < 2; ++a) {
                const double p = positions[row[k]].p[a];
                low[a] = k ? std::min(low[a], p) : p, high[a] = k ? std::max(high[a], p) : p;
            }
        const double width = std::max(high[0] - low[0], 1e-9), height = std::max(high[1] - low[1], 1e-9);
        // about two plots to a cell, and no more than a thousand cells along a side
        const double side = std::max({std::sqrt(2.0 * width * height / std::max(count, 1)), width / 1000.0, height / 1000.0});
        corner[0] = low[0], corner[1] = low[1], over = 1.0 / side;
        across = int(width * over) + 1, down = int(height * over) + 1;
    }
    int column_of(double x) const { return int(std::clamp((x - corner[0]) * over, 0.0, double(across - 1))); }
    int line_of(double y) const { return int(std::clamp((y - corner[1]) * over, 0.0, double(down - 1))); }
    int cell_of(const double *p) const { return line_of(p[1]) * across + column_of(p[0]); }

    void copy(const PlotRows &rows, const std::vector<Fix<double>> &positions) {
        columns = rows.columns, full = rows.full_noise;
        terms = !rows.noise ? 0 : full ? packed_size(columns) : columns;
        fix.resize(count), z.resize(std::size_t(count) * columns), noise.resize(std::size_t(count) * terms);
        log_unit.assign(count, 0.0), code.assign(count, -1), waiting.assign(count, 0), time.resize(rows.time ? count : 0);
        for (double &value : largest) value = 0.0;
        earliest = INFINITY, latest = -INFINITY;
        for (int k = 0; k < count; ++k) {
            const std::int64_t j = row[k];
            fix[k] = positions[j];
            std::copy_n(rows.z + j * columns, columns, &z[std::size_t(k) * columns]);
            for (int r = 0; r < columns && terms; ++r)
                for (int q = 0; q <= r; ++q) {
                    if (full) noise[std::size_t(k) * terms + packed(r, q)] = rows.noise[(j * columns + r) * columns + q];
                    else if (q == r) noise[std::size_t(k) * terms + r] = rows.noise[j * columns + r];
                }
            if (rows.unit) log_unit[k] = std::log(rows.unit[j]);
            if (rows.code) code[k] = rows.code[j];
            if (rows.waiting) waiting[k] = rows.waiting[j] != 0;
            if (rows.time) time[k] = rows.time[j], earliest = std::min(earliest, time[k]), latest = std::max(latest, time[k]);
            for (int a = 0; a < 3; ++a) largest[a] = std::max(largest[a], fix[k].P[packed(a, a)]);
        }
    }
};

}  // namespace jink::inline JINK_LEVEL
