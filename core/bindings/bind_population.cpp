// The Python face of population.hpp.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

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

}  // namespace

void bind_population(nb::module_ &module) {
    module.attr("largest_population_modes") = largest_population_modes;
    module.def("population_errors", errors, "tables"_a, "count"_a, "transition"_a, "probability"_a, "time"_a, "z"_a, "position"_a, "velocity"_a,
               "variance"_a, "result"_a, "threads"_a);
}
