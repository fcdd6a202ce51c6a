// How much measurements scatter: what `tracking/scatter.py` asks of many rows at once.
#include <algorithm>

#include "bindings/bindings.hpp"

namespace {

using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Indices = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

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

}  // namespace

void bind_scatter(nb::module_ &module) {
    module.def("third_differences", third_differences, "time"_a, "values"_a, "new"_a, "longest"_a, "rounding"_a);
    module.def("grouped_quantile", grouped_quantile, "values"_a, "group"_a, "groups"_a, "share"_a, "least"_a);
}
