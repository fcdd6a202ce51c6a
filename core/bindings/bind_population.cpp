// The Python face of population.hpp and candidates.hpp.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "run/candidates.hpp"
#include "run/engine.hpp"
#include "run/numbers.hpp"
#include "run/population.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace jink;

namespace {

using In = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Counts = nb::ndarray<const std::int64_t, nb::c_contig, nb::device::cpu>;
using Out = nb::ndarray<double, nb::c_contig, nb::device::cpu>;

void errors(In tables, Counts count, In transition, In probability, In time, In z, In position, In velocity, double variance, Out result,
            int threads) {
    const auto expect = [](bool right) {
        if (!right) throw nb::value_error("population: shapes do not fit");
    };
    expect(tables.ndim() == 4 && tables.shape(3) == fuzzy_fields && z.ndim() == 2);
    PopulationInput in;
    in.individuals = tables.shape(0), in.modes = tables.shape(1), in.rules = tables.shape(2);
    in.runs = z.shape(0), in.scans = z.shape(1);
    const std::size_t modes = in.individuals * in.modes;
    expect(in.modes >= 1 && in.modes <= largest_population_modes && in.rules >= 1 && count.size() == modes && probability.size() == modes);
    expect(transition.size() == modes * in.modes && result.size() == std::size_t(in.individuals * in.scans * 2));
    expect(time.size() == z.size() && position.size() == z.size() && velocity.size() == z.size());
    for (std::size_t i = 0; i < modes; ++i) expect(count.data()[i] >= 1 && count.data()[i] <= in.rules);
    in.tables = tables.data(), in.count = count.data(), in.transition = transition.data(), in.probability = probability.data();
    in.time = time.data(), in.z = z.data(), in.position = position.data(), in.velocity = velocity.data(), in.variance = variance;
    double *to = result.data();
    nb::gil_scoped_release released;
    population_errors(in, to, threads);
}

void candidates(const Engine &engine, In numbers, In time, In z, Counts offsets, In truth, Out sums, int threads) {
    const Declaration &declaration = engine.pack->declared;
    const std::size_t rows = time.size(), columns = declaration.columns(), each = numbers_of(declaration).size();
    if (!differentiable(declaration) || numbers.ndim() != 2 || numbers.shape(1) != each || sums.ndim() != 3 || sums.shape(2) != 3 ||
        sums.shape(0) != numbers.shape(0) || z.size() != rows * columns || truth.size() != rows * 2 * declaration.axes())
        throw nb::value_error("candidates: shapes do not fit");
    for (std::size_t b = 0; b + 1 < offsets.size(); ++b)
        if (offsets.data()[b + 1] - offsets.data()[b] > std::int64_t(sums.shape(1)) || std::size_t(offsets.data()[b + 1]) > rows)
            throw nb::value_error("candidates: shapes do not fit");
    const BatchInput in{time.data(), z.data(), int(columns), offsets.data(), std::int64_t(offsets.size()) - 1};
    const std::int64_t scans = sums.shape(1), count = numbers.shape(0);
    double *to = sums.data();
    nb::gil_scoped_release released;
    run_candidates(declaration, numbers.data(), count, in, truth.data(), scans, to, threads);
}

}  // namespace

void bind_population(nb::module_ &module) {
    module.attr("largest_population_modes") = largest_population_modes;
    module.def("population_errors", errors, "tables"_a, "count"_a, "transition"_a, "probability"_a, "time"_a, "z"_a, "position"_a, "velocity"_a,
               "variance"_a, "result"_a, "threads"_a);
    module.def("candidate_errors", candidates, "engine"_a, "numbers"_a, "time"_a, "z"_a, "offsets"_a, "truth"_a, "sums"_a, "threads"_a,
               "Of one filter with many sets of numbers: squared errors per scan, and how many tracks they are of, into sums.");
}
