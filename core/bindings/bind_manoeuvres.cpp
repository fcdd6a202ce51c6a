// Whether targets manoeuvre: the probability that an acceleration exceeds a threshold, as `tracking/manoeuvring.py` asks of many rows.
#include <nanobind/stl/optional.h>

#include "bindings/bindings.hpp"
#include "number/elementary.hpp"

namespace {

using Column = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Columns = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

constexpr double unknown = 1e12;  // (m/s^2)^2: the variance of an acceleration of which nothing is known
constexpr double brief = 1e-3;    // s: over less than that a velocity does not change

Pack within(Pack x, double low, double high) { return larger<Pack>(smaller<Pack>(x, splat<Pack>(high)), splat<Pack>(low)); }

// P(n > z) of a standard normal n, by a logistic function: to 2e-4.
Pack beyond(Pack z) {
    z = within(z, -8.0, 8.0);
    return 1.0 / (1.0 + exponential<Pack>(z * (1.5976 + 0.07056 * z * z)));
}

// P(|a| > r) of a normal vector of one or two components, each of this variance, whose mean has this size. Of two components |a|^2 / variance
// is noncentral chi-square, and a power of it is nearly normal (to .02). Source: Sankaran, Biometrika 50, 1963.
Pack exceeds(Pack mean, Pack variance, double r, int components) {
    variance = larger<Pack>(variance, splat<Pack>(1e-6 * r * r));
    if (components == 1) {
        const Pack over = 1.0 / square_root(variance);
        return beyond((r - mean) * over) + beyond((r + mean) * over);
    }
    const Pack away = mean * mean / variance, x = r * r / variance;
    const Pack one = 2.0 + away, two = 2.0 + 2.0 * away, three = 2.0 + 3.0 * away;
    const Pack h = 1.0 - 2.0 / 3.0 * one * three / (two * two), p = two / (one * one), m = (h - 1.0) * (1.0 - 3.0 * h);
    const Pack centre = 1.0 + h * p * (h - 1.0 - 0.5 * (2.0 - h) * m * p);
    const Pack power = exponential<Pack>(h * logarithm<Pack>(x / one));
    return beyond((power - centre) / (h * square_root(2.0 * p) * (1.0 + 0.5 * m * p)));
}

// What a direction's rows show: velocities (k, N) with the variance (N,) of one component, accelerations likewise, or none.
struct Direction {
    Columns velocity;
    Column variance;
    std::optional<Columns> acceleration;
    std::optional<Column> spread;
};

// The probabilities of `lanes` rows: row[l] is weighed by its modes, over the rows first[l] to last[l].
Pack manoeuvring(const Direction &of, const double *time, const double *mode, const std::int64_t *row, const std::int64_t *first,
                 const std::int64_t *last, double window, double straight_noise, double r) {
    const auto gather = [](const double *from, const std::int64_t *which) {
        double lane[lanes];
        for (int l = 0; l < lanes; ++l) lane[l] = from[which[l]];
        return load<Pack>(lane);
    };
    const int components = int(of.velocity.shape(0));
    const std::size_t rows = of.velocity.shape(1);
    const Pack elapsed = gather(time, last) - gather(time, first), most = splat<Pack>(unknown), zero = splat<Pack>(0.0);
    const PackMask still = elapsed < splat<Pack>(brief);
    const Pack over = 1.0 / select<Pack>(still, splat<Pack>(window), elapsed), share = gather(mode, row);
    Pack change[2] = {zero, zero}, square = zero;
    for (int c = 0; c < components; ++c) {
        const double *v = of.velocity.data() + c * rows;
        change[c] = (gather(v, last) - gather(v, first)) * over;
        square = square + change[c] * change[c];
    }
    const Pack both = (gather(of.variance.data(), first) + gather(of.variance.data(), last)) * over * over;
    const Pack unsure = select<Pack>(still, most, smaller<Pack>(both, most));
    // the square of a change that errors of the velocity made is their variance: it is taken off in the mean, so that what is left counts
    // the less, the larger it is beside the threshold
    const Pack straight = square_root(larger<Pack>(square - unsure * double(components), zero)) / (1.0 + unsure / (r * r));
    const Pack quiet = exceeds(straight, straight_noise * over, r, components);
    Pack size = square, variance = unsure, poison = share + square + select<Pack>(still, zero, both);
    if (of.acceleration) {
        // in the straight modes the acceleration is zero, so those of the others are the mixture's without it; the change of the velocity
        // is weighed by its variance
        const Pack some = 1.0 / larger<Pack>(share, splat<Pack>(1e-6));
        Pack own[2], mixed = zero;
        for (int c = 0; c < components; ++c) own[c] = gather(of.acceleration->data() + c * rows, row), mixed = mixed + own[c] * own[c];
        mixed = mixed * (1.0 / components);
        const Pack spread = gather(of.spread->data(), row);
        poison = poison + mixed + spread;
        variance = within((spread + mixed) * some - mixed * some * some, 1e-9, unknown);
        const Pack weight = variance / (variance + unsure);
        size = zero;
        for (int c = 0; c < components; ++c) {
            const Pack mean = own[c] * some + weight * (change[c] - own[c] * some);
            size = size + mean * mean;
        }
        variance = smaller<Pack>(variance, unsure);
    }
    const Pack found = (1.0 - share) * quiet + share * exceeds(square_root(size), variance, r, components);
    return select<Pack>(is_nan(poison), nan_of<Pack>(), found);
}

// Of rows 0 to M - 1 the probability (M,) that the mean acceleration between the rows first (M,) and last (M,) exceeds a threshold.
nb::object manoeuvring_of(Column time, Indices first, Indices last, Column mode, Columns velocity, Column variance, std::optional<Columns> acceleration,
                          std::optional<Column> spread, double window, double straight, double threshold) {
    const std::size_t rows = time.size(), count = first.size(), components = velocity.shape(0);
    bool fits = last.size() == count && count <= rows && mode.size() == rows && velocity.shape(1) == rows && variance.size() == rows;
    fits &= (components == 1 || components == 2) && acceleration.has_value() == spread.has_value();
    if (acceleration) fits &= acceleration->shape(0) == components && acceleration->shape(1) == rows && spread->size() == rows;
    for (std::size_t k = 0; fits && k < count; ++k)
        for (const std::int64_t row : {first.data()[k], last.data()[k]}) fits &= row >= 0 && row < std::int64_t(rows);
    if (!fits) throw nb::value_error("manoeuvring: expected rows of one table");
    std::vector<double> out(count);
    {
        nb::gil_scoped_release released;
        const Direction of{velocity, variance, acceleration, spread};
        for (std::size_t k = 0; k < count; k += lanes) {
            std::int64_t row[lanes], begin[lanes], end[lanes];
            for (int l = 0; l < lanes; ++l) {
                row[l] = std::int64_t(std::min(k + l, count - 1));
                begin[l] = first.data()[row[l]], end[l] = last.data()[row[l]];
            }
            const Pack found = manoeuvring(of, time.data(), mode.data(), row, begin, end, window, straight, threshold);
            for (int l = 0; l < lanes && k + l < count; ++l) out[k + l] = found[l];
        }
    }
    return array_of(std::move(out), {count});
}

// Of the rows (N,) of tracks laid end to end, which begin where `begins` (N,) says, the first row at most `back` seconds before each and the last
// one at most `ahead` seconds after it: at least one row back, and one on unless `ahead` is 0, as far as the track goes.
nb::tuple windows_of(Column time, Flags begins, double back, double ahead) {
    const std::int64_t rows = std::int64_t(time.size());
    if (std::int64_t(begins.size()) != rows) throw nb::value_error("windows: expected rows of one table");
    std::vector<std::int64_t> first(rows), last(rows);
    const double *t = time.data();
    const bool *begin = begins.data();
    for (std::int64_t low = 0, end; low < rows; low = end) {
        for (end = low + 1; end < rows && !begin[end];) ++end;
        for (std::int64_t row = low, from = low, to = low; row < end; ++row) {
            while (from < row && t[from] < t[row] - back) ++from;
            first[row] = std::max(std::min(from, row - 1), low);
            while (to + 1 < end && t[to + 1] <= t[row] + ahead) ++to;
            last[row] = ahead > 0.0 ? std::max(to, std::min(row + 1, end - 1)) : row;
        }
    }
    const std::size_t shape = std::size_t(rows);
    return nb::make_tuple(array_of(std::move(first), {shape}), array_of(std::move(last), {shape}));
}

}  // namespace

void bind_manoeuvres(nb::module_ &module) {
    module.def("manoeuvring", manoeuvring_of, "time"_a, "first"_a, "last"_a, "mode"_a, "velocity"_a, "variance"_a, "acceleration"_a.none(),
               "spread"_a.none(), "window"_a, "straight"_a, "threshold"_a);
    module.def("windows", windows_of, "time"_a, "begins"_a, "back"_a, "ahead"_a);
}
