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

// The same of `lanes` matrices in a row; false says nothing.
bool surely_definite(const double *R, std::size_t m) {
    double packs[largest_measurement * largest_measurement * lanes];
    const double *from[lanes];
    for (int l = 0; l < lanes; ++l) from[l] = R + l * m * m;
    if (m >= 2 && m <= largest_measurement) to_lanes(from, std::int64_t(m * m), packs);
    switch (m) {
        case 2: return surely_definite<2>(packs);
        case 3: return surely_definite<3>(packs);
        case 4: return surely_definite<4>(packs);
        case 5: return surely_definite<5>(packs);
        case 6: return surely_definite<6>(packs);
        default: return false;
    }
}

// The first of matrices (N, m, m) that is not finite, symmetric and positive definite; -1: none.
std::int64_t first_indefinite(nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu> matrices) {
    const std::size_t count = matrices.shape(0), m = matrices.shape(1);
    if (matrices.shape(2) != m) throw wrong("matrices: expected (N, m, m)");
    nb::gil_scoped_release released;
    Vector scratch;
    for (std::size_t first = 0; first < count; first += lanes) {
        const std::size_t end = std::min(count, first + lanes);
        if (end == first + lanes && surely_definite(matrices.data() + first * m * m, m)) continue;
        for (std::size_t row = first; row < end; ++row) {
            const double *R = matrices.data() + row * m * m;
            if (!all_finite(R, m * m) || !positive_definite(R, int(m), scratch)) return std::int64_t(row);
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

void bind_checks(nb::module_ &module) {
    module.def("first_indefinite", first_indefinite, "matrices"_a);
    module.def("keep_freed_memory", keep_freed_memory);
}
