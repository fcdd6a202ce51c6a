// How much measurements scatter: what `tracking/scatter.py` asks of many rows at once.
#include <algorithm>

#include "bindings/bindings.hpp"

namespace {

// Does a value change from row k to the next by more than rounding? Not where it is missing.
bool changes(const double *value, std::size_t m, std::size_t k, double rounding) {
    double most = 0.0;
    for (std::size_t c = 0; c < m; ++c) {
        const double moved = std::abs(value[(k + 1) * m + c] - value[k * m + c]);
        if (std::isnan(moved)) return false;
        most = std::max(most, moved);
    }
    return most > rounding;
}

// The combinations of four successive rows (K, m) of one track that annihilate any parabola, and the second row of each (K,):
// see third_differences in scatter.py. longest: the largest step (s) of a window.
nb::tuple third_differences(Const time, nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> values, Flags is_new,
                            double longest, double rounding) {
    const std::size_t count = time.size(), m = values.shape(1);
    if (values.shape(0) != count || is_new.size() != count) throw nb::value_error("third_differences: expected as many values as times");
    std::vector<double> found;
    std::vector<std::int64_t> index;
    {
        nb::gil_scoped_release released;
        const double *t = time.data(), *z = values.data();
        std::size_t fine = 0;  // steps in a row that are
        std::size_t last = 0;  // one more than the latest step at which a value changed
        for (std::size_t k = 0; k + 1 < count; ++k) {
            const double step = t[k + 1] - t[k];
            fine = !is_new.data()[k + 1] && step > 0.0 && step <= longest ? fine + 1 : 0;
            if (changes(z, m, k, rounding)) last = k + 1;
            if (fine < 3 || last + 2 < k + 1) continue;
            const double *s = t + k - 2, *v = z + (k - 2) * m;
            const double a = s[1] - s[0], b = s[2] - s[1], c = s[3] - s[2], ab = a + b, bc = b + c;
            double w[4] = {-1.0 / (a * ab * (a + bc)), 1.0 / (a * b * bc), -1.0 / (ab * b * c), 1.0 / ((a + bc) * bc * c)};
            const double scale = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
            for (double &each : w) each /= scale;
            for (std::size_t i = 0; i < m; ++i) found.push_back(w[0] * v[i] + w[1] * v[m + i] + w[2] * v[2 * m + i] + w[3] * v[3 * m + i]);
            index.push_back(std::int64_t(k) - 1);
        }
    }
    const std::size_t windows = index.size();
    return nb::make_tuple(array_of(std::move(found), {windows, m}), array_of(std::move(index), {windows}));
}

// Of the finite values (N,) or (N, m) of each group (N,) the one nearest to a quantile (G,); NaN of a group with fewer than `least`.
nb::object grouped_quantile(Const values, Indices group, std::int64_t groups, double share, std::int64_t least) {
    const std::size_t rows = group.size(), width = rows ? values.size() / rows : 1, count = values.size();
    if (rows * width != count || groups < 0) throw nb::value_error("grouped_quantile: expected a group of each row");
    std::vector<double> out(groups, std::nan("")), known(count);
    {
        nb::gil_scoped_release released;
        const double *value = values.data();
        std::vector<std::size_t> end(groups + 1, 0);
        for (std::size_t k = 0; k < count; ++k) {
            const std::int64_t mine = group.data()[k / width];
            if (mine < 0 || mine >= groups) throw nb::value_error("grouped_quantile: expected groups from 0 to G - 1");
            end[mine + 1] += std::isfinite(value[k]);
        }
        for (std::int64_t g = 0; g < groups; ++g) end[g + 1] += end[g];
        const std::vector<std::size_t> start = end;
        for (std::size_t k = 0; k < count; ++k)
            if (std::isfinite(value[k])) known[end[group.data()[k / width]]++] = value[k];
        for (std::int64_t g = 0; g < groups; ++g) {
            const std::int64_t mine = start[g + 1] - start[g];
            if (mine == 0 || mine < least) continue;
            const auto from = known.begin() + start[g], at = from + std::int64_t(std::round(double(mine - 1) * share));
            std::nth_element(from, at, from + mine);
            out[g] = *at;
        }
    }
    return array_of(std::move(out), {std::size_t(groups)});
}

using Pairs = nb::ndarray<const double, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;

struct Pair {
    double x, y;
};

Pair pair(Pairs of, std::int64_t k) { return {of.data()[2 * k], of.data()[2 * k + 1]}; }
Pair minus(Pair a, Pair b) { return {a.x - b.x, a.y - b.y}; }
double length(Pair a) { return std::sqrt(a.x * a.x + a.y * a.y); }

// Calls `each(k, first, end)` for the rows of each part, whose first rows are marked.
template <class Each> void in_parts(Flags is_new, Each each) {
    const std::int64_t count = is_new.size();
    for (std::int64_t first = 0, end; first < count; first = end) {
        for (end = first + 1; end < count && !is_new.data()[end];) ++end;
        for (std::int64_t k = first; k < end; ++k) each(k, first, end);
    }
}

double middle(double a, double b, double c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

// Velocities (N, 2) from steps over `reach` rows: see rough_velocity in scatter.py.
nb::object rough_velocity(Const time, Pairs plane, Flags is_new, std::int64_t reach) {
    if (plane.shape(0) != time.size() || is_new.size() != time.size() || reach < 1)
        throw nb::value_error("rough_velocity: expected as many positions and marks as times");
    std::vector<double> out(2 * time.size());
    {
        nb::gil_scoped_release released;
        in_parts(is_new, [&](std::int64_t k, std::int64_t first, std::int64_t end) {
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
// radians: see _way in reported.py. reach and noise: of each part.
nb::tuple ways(Pairs plane, Flags is_new, Indices reach, Const noise) {
    const std::size_t count = plane.shape(0);
    std::size_t parts = 0;
    for (std::size_t k = 0; k < is_new.size(); ++k) parts += k == 0 || is_new.data()[k];
    if (is_new.size() != count || reach.size() != parts || noise.size() != parts)
        throw nb::value_error("ways: expected a mark for each position, a reach and a noise for each part");
    std::vector<double> way(2 * count, std::nan("")), angle(count, 0.0);
    {
        nb::gil_scoped_release released;
        std::int64_t part = -1;
        in_parts(is_new, [&](std::int64_t k, std::int64_t first, std::int64_t) {
            part += k == first;
            const std::int64_t before = std::max(k - std::max<std::int64_t>(reach.data()[part], 0), first);
            const Pair moved = minus(pair(plane, k), pair(plane, before));
            const double far = length(moved), error = noise.data()[part];
            if (before == k || !(far > 10.0 * error)) return;
            const double x = moved.x / far, y = moved.y / far, turned = 1.0 - std::clamp(x * way[2 * before] + y * way[2 * before + 1], 0.0, 1.0);
            way[2 * k] = x, way[2 * k + 1] = y;
            // in a turn the way lags behind by half of what it turned since the positions that it begins with
            angle[k] = error / far * (error / far) + 0.5 * (std::isnan(turned) ? 1.0 : turned);
        });
    }
    return nb::make_tuple(array_of(std::move(way), {count, 2}), array_of(std::move(angle), {count}));
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
    module.def("third_differences", third_differences, "time"_a, "values"_a, "new"_a, "longest"_a, "rounding"_a);
    module.def("grouped_quantile", grouped_quantile, "values"_a, "group"_a, "groups"_a, "share"_a, "least"_a);
    module.def("rough_velocity", rough_velocity, "time"_a, "plane"_a, "new"_a, "reach"_a);
    module.def("ways", ways, "plane"_a, "new"_a, "reach"_a, "noise"_a);
    module.def("across_and_along", across_and_along, "difference"_a, "index"_a, "velocity"_a, "least"_a);
}
