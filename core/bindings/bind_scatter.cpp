// How much measurements scatter: what `tracking/scatter.py` and `tracking/reported.py` ask of many rows at once.
#include <algorithm>
#include <optional>

#include <nanobind/stl/optional.h>

#include "bindings/bindings.hpp"

namespace {

using Pairs = nb::ndarray<const double, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;
using Table = nb::ndarray<const double, nb::ndim<2>, nb::device::cpu>;  // columns of a larger one, too

struct Pair {
    double x, y;
};

Pair pair(const Pairs &of, std::int64_t k) { return {of.data()[2 * k], of.data()[2 * k + 1]}; }
Pair pair(const Table &of, std::int64_t k) {
    const double *row = of.data() + k * of.stride(0);
    return {row[0], row[of.stride(1)]};
}
Pair minus(Pair a, Pair b) { return {a.x - b.x, a.y - b.y}; }
double length(Pair a) { return std::sqrt(a.x * a.x + a.y * a.y); }

// Calls `each(first, end)` for the rows of each track, whose first rows are marked.
template <class Each> void for_tracks(Flags is_new, Each each) {
    const std::int64_t count = is_new.size();
    for (std::int64_t first = 0, end; first < count; first = end) {
        for (end = first + 1; end < count && !is_new.data()[end];) ++end;
        each(first, end);
    }
}

// Calls `each(k, first, end)` for every row k of each track.
template <class Each> void in_tracks(Flags is_new, Each each) {
    for_tracks(is_new, [&](std::int64_t first, std::int64_t end) {
        for (std::int64_t k = first; k < end; ++k) each(k, first, end);
    });
}

// The median step (s) between every `spacing`-th row of the tracks, 0 where there is none.
double usual_step(Const time, Flags is_new, std::int64_t spacing) {
    if (is_new.size() != time.size() || spacing < 1) throw nb::value_error("usual_step: expected a mark for each time");
    nb::gil_scoped_release released;
    std::vector<double> steps;
    steps.reserve(time.size() / spacing);
    for_tracks(is_new, [&](std::int64_t first, std::int64_t end) {
        for (std::int64_t k = first + spacing; k < end; k += spacing) steps.push_back(time.data()[k] - time.data()[k - spacing]);
    });
    if (steps.empty()) return 0.0;
    const auto middle = steps.begin() + steps.size() / 2;
    std::nth_element(steps.begin(), middle, steps.end());
    return steps.size() % 2 ? *middle : 0.5 * (*middle + *std::max_element(steps.begin(), middle));
}

// What annihilates parabolas over four times that are these steps apart, with squares that sum up to one.
struct Weights {
    double a = 0.0, b = 0.0, c = 0.0, w[4] = {};

    void over(double first, double second, double third) {
        if (first == a && second == b && third == c) return;
        a = first, b = second, c = third;
        const double ab = a + b, bc = b + c;
        w[0] = -1.0 / (a * ab * (a + bc)), w[1] = 1.0 / (a * b * bc), w[2] = -1.0 / (ab * b * c), w[3] = 1.0 / ((a + bc) * bc * c);
        const double scale = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
        for (double &each : w) each /= scale;
    }
};

// Does a value change between two rows of m by more than rounding? Not where it is missing.
bool changes(const double *before, const double *after, std::size_t m, double rounding) {
    double most = 0.0;
    for (std::size_t c = 0; c < m; ++c) {
        const double moved = std::abs(after[c] - before[c]);
        if (std::isnan(moved)) return false;
        most = std::max(most, moved);
    }
    return most > rounding;
}

// The combinations of four successive rows (K, m) of one track that annihilate any parabola, and the second row of each (K,):
// see third_differences in scatter.py. longest: the largest step (s) of a window; spacing: every so many rows of a track are looked at.
nb::tuple third_differences(Const time, nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> values, Flags is_new,
                            double longest, double rounding, std::int64_t spacing) {
    const std::size_t count = time.size(), m = values.shape(1);
    if (values.shape(0) != count || is_new.size() != count || spacing < 1)
        throw nb::value_error("third_differences: expected as many values as times");
    std::vector<double> found;
    std::vector<std::int64_t> index;
    {
        nb::gil_scoped_release released;
        found.reserve(count / spacing * m), index.reserve(count / spacing);  // pages that nothing is written to cost nothing
        const double *t = time.data(), *z = values.data();
        Weights weights;
        for_tracks(is_new, [&](std::int64_t first, std::int64_t end) {
            int fine = 0, still = 3;  // steps in a row that are; in which no value changed
            for (std::int64_t k = first + spacing; k < end; k += spacing) {
                const std::int64_t before = k - spacing;
                const double step = t[k] - t[before];
                fine = step > 0.0 && step <= longest ? fine + 1 : 0;
                still = changes(z + before * m, z + k * m, m, rounding) ? 0 : still + 1;
                if (fine < 3 || still >= 3) continue;
                const std::int64_t two = before - spacing, three = two - spacing;
                weights.over(t[two] - t[three], t[before] - t[two], step);
                const double *w = weights.w;
                for (std::size_t i = 0; i < m; ++i)
                    found.push_back(w[0] * z[three * m + i] + w[1] * z[two * m + i] + w[2] * z[before * m + i] + w[3] * z[k * m + i]);
                index.push_back(two);
            }
        });
    }
    const std::size_t windows = index.size();
    return nb::make_tuple(array_of(std::move(found), {windows, m}), array_of(std::move(index), {windows}));
}

// The rows (N,) so that those of a group stand together, in their order; empty where they do already.
std::vector<std::size_t> by_group(Indices group, std::int64_t groups) {
    const std::int64_t *of = group.data(), count = group.size();
    std::vector<std::size_t> place(groups + 1, 0), rows;
    for (std::int64_t k = 0; k < count; ++k) {
        if (of[k] < 0 || of[k] >= groups) throw nb::value_error("grouped_quantile: expected groups from 0 to G - 1");
        ++place[of[k] + 1];
    }
    if (std::is_sorted(of, of + count)) return rows;
    for (std::int64_t g = 0; g < groups; ++g) place[g + 1] += place[g];
    rows.resize(count);
    for (std::int64_t k = 0; k < count; ++k) rows[place[of[k]]++] = k;
    return rows;
}

// Of the finite values (N,) or (N, m) of each group (N,) the one nearest to a quantile (G,); NaN of a group with fewer than `least`.
nb::object grouped_quantile(Const values, Indices group, std::int64_t groups, double share, std::int64_t least) {
    const std::size_t rows = group.size(), width = rows ? values.size() / rows : 1;
    if (rows * width != values.size() || groups < 0) throw nb::value_error("grouped_quantile: expected a group of each row");
    std::vector<double> out(groups, std::nan("")), known;
    {
        nb::gil_scoped_release released;
        const std::vector<std::size_t> order = by_group(group, groups);
        const auto row = [&](std::size_t k) { return order.empty() ? k : order[k]; };
        for (std::size_t k = 0; k < rows;) {
            const std::int64_t mine = group.data()[row(k)];
            known.clear();
            for (; k < rows && group.data()[row(k)] == mine; ++k)
                for (const double *value = values.data() + row(k) * width, *end = value + width; value < end; ++value)
                    if (std::isfinite(*value)) known.push_back(*value);
            const std::int64_t count = known.size();
            if (count == 0 || count < least) continue;
            const auto at = known.begin() + std::int64_t(std::round(double(count - 1) * share));
            std::nth_element(known.begin(), at, known.end());
            out[mine] = *at;
        }
    }
    return array_of(std::move(out), {std::size_t(groups)});
}

double middle(double a, double b, double c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

// Velocities (N, 2) from steps over `reach` rows: see rough_velocity in scatter.py.
nb::object rough_velocity(Const time, Pairs plane, Flags is_new, std::int64_t reach) {
    if (plane.shape(0) != time.size() || is_new.size() != time.size() || reach < 1)
        throw nb::value_error("rough_velocity: expected as many positions and marks as times");
    std::vector<double> out(2 * time.size());
    {
        nb::gil_scoped_release released;
        in_tracks(is_new, [&](std::int64_t k, std::int64_t first, std::int64_t end) {
            const auto slope = [&](std::int64_t back, std::int64_t forward) {
                const std::int64_t a = std::max(k - back, first), b = std::min(k + forward, end - 1);
                const double elapsed = time.data()[b] - time.data()[a];
                const Pair moved = minus(pair(plane, b), pair(plane, a));
                return elapsed > 0.0 ? Pair{moved.x / elapsed, moved.y / elapsed} : Pair{std::nan(""), std::nan("")};
            };
            const Pair before = slope(reach, 0), after = slope(0, reach), wide = slope(2 * reach, 2 * reach);
            const auto of = [&](double Pair::*axis) {
                const double instead = wide.*axis, one = before.*axis, other = after.*axis;
                if (std::isnan(instead)) return 0.0;
                return middle(std::isnan(one) ? instead : one, std::isnan(other) ? instead : other, instead);
            };
            out[2 * k] = of(&Pair::x), out[2 * k + 1] = of(&Pair::y);
        });
    }
    return array_of(std::move(out), {time.size(), 2});
}

// Unit vectors (N, 2) along which the last `reach` positions lead, NaN where their noise hides it, and how uncertain they are (N,), in
// radians: see _way in reported.py. reach and noise: of each track.
nb::tuple ways(Pairs plane, Flags is_new, Indices reach, Const noise) {
    const std::size_t count = plane.shape(0);
    std::size_t tracks = 0;
    for (std::size_t k = 0; k < is_new.size(); ++k) tracks += k == 0 || is_new.data()[k];
    if (is_new.size() != count || reach.size() != tracks || noise.size() != tracks)
        throw nb::value_error("ways: expected a mark for each position, a reach and a noise for each track");
    std::vector<double> way(2 * count, std::nan("")), angle(count, 0.0);
    {
        nb::gil_scoped_release released;
        std::int64_t track = -1;
        in_tracks(is_new, [&](std::int64_t k, std::int64_t first, std::int64_t) {
            track += k == first;
            const std::int64_t before = std::max(k - std::max<std::int64_t>(reach.data()[track], 0), first);
            const Pair moved = minus(pair(plane, k), pair(plane, before));
            const double far = length(moved), error = noise.data()[track];
            if (before == k || !(far > 10.0 * error)) return;
            const double x = moved.x / far, y = moved.y / far, share = error / far;
            const double turned = 1.0 - std::clamp(x * way[2 * before] + y * way[2 * before + 1], 0.0, 1.0);
            way[2 * k] = x, way[2 * k + 1] = y;
            // in a turn the way lags behind by half of what it turned since the positions that it begins with
            angle[k] = share * share + 0.5 * (std::isnan(turned) ? 1.0 : turned);
        });
    }
    return nb::make_tuple(array_of(std::move(way), {count, 2}), array_of(std::move(angle), {count}));
}

// How far velocities are from those that positions show (N, 2), along the way (N, 2) where they were measured along it: see _off in
// reported.py.
nb::object off(Table velocity, Pairs shown, std::optional<Pairs> way) {
    const std::size_t count = shown.shape(0);
    if (velocity.shape(0) != count || velocity.shape(1) < 2 || (way && way->shape(0) != count))
        throw nb::value_error("off: expected two components of each velocity");
    std::vector<double> out(count);
    {
        nb::gil_scoped_release released;
        for (std::size_t k = 0; k < count; ++k) {
            const Pair error = minus(pair(velocity, k), pair(shown, k));
            out[k] = way ? std::abs(error.x * pair(*way, k).x + error.y * pair(*way, k).y) : length(error);
        }
    }
    return array_of(std::move(out), {count});
}

// Variances of vx and vy, and their covariance (N,), of velocities that are measured along the way (N, 2) alone, with these variances
// (N,). Nothing is known across it but that a target does not move across it faster than along it.
nb::tuple along_the_way(Const along, Pairs way, Table velocity) {
    const std::size_t count = along.size();
    if (velocity.shape(0) != count || velocity.shape(1) < 2 || way.shape(0) != count)
        throw nb::value_error("along_the_way: expected two components of each velocity");
    std::vector<double> xx(count), yy(count), xy(count);
    {
        nb::gil_scoped_release released;
        for (std::size_t k = 0; k < count; ++k) {
            const Pair w = pair(way, k);
            const double mine = along.data()[k], speed = length(pair(velocity, k));
            const double far = (std::isnan(speed) ? 0.0 : speed) + 10.0 * std::sqrt(mine), across = far * far;
            const bool known = !std::isnan(w.x);
            xx[k] = known ? mine * w.x * w.x + across * w.y * w.y : mine;
            yy[k] = known ? mine * w.y * w.y + across * w.x * w.x : mine;
            xy[k] = known ? mine * w.x * w.y - across * w.y * w.x : 0.0;
        }
    }
    return nb::make_tuple(array_of(std::move(xx), {count}), array_of(std::move(yy), {count}), array_of(std::move(xy), {count}));
}

// Of differences (K, 2) their parts across a velocity (m) and along it (s), and the speed, NaN below `least`: (K,) each. index: the row of
// `velocity` that is that of a difference.
nb::tuple across_and_along(Pairs difference, Indices index, Pairs velocity, double least) {
    const std::size_t count = index.size();
    if (difference.shape(0) != count) throw nb::value_error("across_and_along: expected a row for each difference");
    std::vector<double> across(count), along(count), speeds(count);
    for (std::size_t k = 0; k < count; ++k) {
        const std::int64_t row = index.data()[k];
        if (row < 0 || row >= std::int64_t(velocity.shape(0))) throw nb::value_error("across_and_along: expected rows of the velocities");
        const Pair d = pair(difference, k), v = pair(velocity, row);
        const double found = length(v), speed = found < least ? std::nan("") : found;
        across[k] = std::abs(d.x * v.y - d.y * v.x) / speed, along[k] = std::abs(d.x * v.x + d.y * v.y) / (speed * speed), speeds[k] = speed;
    }
    return nb::make_tuple(array_of(std::move(across), {count}), array_of(std::move(along), {count}), array_of(std::move(speeds), {count}));
}

}  // namespace

void bind_scatter(nb::module_ &module) {
    module.def("usual_step", usual_step, "time"_a, "new"_a, "spacing"_a);
    module.def("third_differences", third_differences, "time"_a, "values"_a, "new"_a, "longest"_a, "rounding"_a, "spacing"_a);
    module.def("grouped_quantile", grouped_quantile, "values"_a, "group"_a, "groups"_a, "share"_a, "least"_a);
    module.def("rough_velocity", rough_velocity, "time"_a, "plane"_a, "new"_a, "reach"_a);
    module.def("ways", ways, "plane"_a, "new"_a, "reach"_a, "noise"_a);
    module.def("off", off, "velocity"_a, "shown"_a, "way"_a.none());
    module.def("along_the_way", along_the_way, "along"_a, "way"_a, "velocity"_a);
    module.def("across_and_along", across_and_along, "difference"_a, "index"_a, "velocity"_a, "least"_a);
}
