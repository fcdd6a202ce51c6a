// What Python checks of many rows at once, and how the process keeps its memory.
#include "bindings/bindings.hpp"
#include "bindings/live_checks.hpp"
#include "number/transpose.hpp"
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

// Are all of these matrices (m x m packs) symmetric to the last bit, and positive definite beyond doubt?
template <int m> bool surely_definite(const double *packs) {
    Pack L[m][m];  // times its pivots
    PackMask sure = splat_mask<Pack>(true);
    const auto at = [&](int r, int q) { return load<Pack>(packs + (r * m + q) * lanes); };
    JINK_UNROLL
    for (int q = 0; q < m; ++q) {
        Pack pivot = at(q, q), over;
        JINK_UNROLL
        for (int r = q; r < m; ++r) {
            sure = sure & (at(r, q) == at(q, r));
            Pack sum = at(r, q);
            JINK_UNROLL
            for (int k = 0; k < q; ++k) sum = sum - L[r][k] * L[q][k] * L[k][k];
            if (r == q) pivot = sum, over = 1.0 / sum;
            else L[r][q] = sum * over;
        }
        L[q][q] = pivot;
        sure = sure & (pivot > splat<Pack>(0.0)) & (pivot <= splat<Pack>(std::numeric_limits<double>::max()));
    }
    return all(sure);
}

constexpr int most_elements = largest_measurement * largest_measurement;

// The same of any size; false says nothing.
bool surely_definite(const double *packs, std::size_t m) {
    switch (m) {
        case 2: return surely_definite<2>(packs);
        case 3: return surely_definite<3>(packs);
        case 4: return surely_definite<4>(packs);
        case 5: return surely_definite<5>(packs);
        case 6: return surely_definite<6>(packs);
        default: return false;
    }
}

// The same of `lanes` matrices in a row.
bool surely_definite_in_a_row(const double *R, std::size_t m) {
    double packs[most_elements * lanes];
    const double *from[lanes];
    for (int l = 0; l < lanes; ++l) from[l] = R + l * m * m;
    if (m < 2 || m > largest_measurement) return false;
    to_lanes(from, std::int64_t(m * m), packs);
    return surely_definite(packs, m);
}

// Is a matrix finite, symmetric and positive definite?
bool definite(const double *R, std::size_t m, Vector &scratch) { return all_finite(R, m * m) && positive_definite(R, int(m), scratch); }

// The first of matrices (N, m, m) that is not finite, symmetric and positive definite; -1: none.
std::int64_t first_indefinite(nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu> matrices) {
    const std::size_t count = matrices.shape(0), m = matrices.shape(1);
    if (matrices.shape(2) != m) throw wrong("matrices: expected (N, m, m)");
    nb::gil_scoped_release released;
    Vector scratch;
    for (std::size_t first = 0; first < count; first += lanes) {
        const std::size_t end = std::min(count, first + lanes);
        if (end == first + lanes && surely_definite_in_a_row(matrices.data() + first * m * m, m)) continue;
        for (std::size_t row = first; row < end; ++row)
            if (!definite(matrices.data() + row * m * m, m, scratch)) return std::int64_t(row);
    }
    return -1;
}

// The same of matrices (m, m) that are given by what is not zero in them.
std::int64_t first_indefinite_row(std::size_t m, nb::list columns) {
    const std::size_t count = nb::len(columns) ? nb::cast<Const>(columns[0][2], false).size() : 0;
    const std::vector<NoiseColumn> given = noise_columns_of(columns, int(m), count);
    nb::gil_scoped_release released;
    double packs[most_elements * lanes] = {}, R[most_elements];
    Vector scratch;
    for (std::size_t first = 0; first < count; first += lanes) {
        const std::size_t used = std::min<std::size_t>(lanes, count - first);
        for (const NoiseColumn &each : given)
            for (std::size_t l = 0; l < lanes; ++l)
                packs[(each.row * m + each.column) * lanes + l] = packs[(each.column * m + each.row) * lanes + l] = each.values[first + std::min(l, used - 1)];
        if (surely_definite(packs, m)) continue;
        for (std::size_t l = 0; l < used; ++l) {
            for (std::size_t e = 0; e < m * m; ++e) R[e] = packs[e * lanes + l];
            if (!definite(R, m, scratch)) return std::int64_t(first + l);
        }
    }
    return -1;
}

// Arrays up to 32 MB that are freed stay with the process for the next ones, which then cost no new pages.
void keep_freed_memory() {
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 1 << 25);
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}

}  // namespace

std::vector<NoiseColumn> noise_columns_of(nb::list columns, int size, std::size_t rows) {
    std::vector<NoiseColumn> out;
    if (size > largest_measurement) throw wrong("noise: too many components");
    for (nb::handle each : columns) {
        const auto values = nb::cast<Const>(each[2], false);
        out.push_back({nb::cast<int>(each[0]), nb::cast<int>(each[1]), values.data()});
        const auto [row, column, _] = out.back();
        if (row < 0 || row >= size || column < 0 || column >= size || values.size() != rows) throw wrong("noise: expected elements of each row's noise");
    }
    return out;
}

void bind_checks(nb::module_ &module) {
    module.def("first_indefinite", first_indefinite, "matrices"_a);
    module.def("first_indefinite_row", first_indefinite_row, "size"_a, "columns"_a);
    module.def("keep_freed_memory", keep_freed_memory);
}
