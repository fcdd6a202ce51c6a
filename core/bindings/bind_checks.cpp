// What Python checks of many rows at once, and how the process keeps its memory.
#include "bindings/bindings.hpp"
#include "bindings/live_checks.hpp"
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

// The first of matrices (N, m, m) that is not finite, symmetric and positive definite; -1: none.
std::int64_t first_indefinite(nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu> matrices) {
    const std::size_t count = matrices.shape(0), m = matrices.shape(1);
    nb::gil_scoped_release released;
    Vector scratch;
    for (std::size_t row = 0; row < count; ++row) {
        const double *R = matrices.data() + row * m * m;
        if (!all_finite(R, m * m) || !positive_definite(R, int(m), scratch)) return std::int64_t(row);
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
