// Gradients through the filter for Python: private to the package, which checks its arguments before they come here.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

#include "run/engine.hpp"
#include "run/gradient.hpp"
#include "run/numbers.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace jink;

namespace {

using In = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Out = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using Index = nb::ndarray<const std::int64_t, nb::c_contig, nb::device::cpu>;
using Sensors = nb::ndarray<const std::int32_t, nb::c_contig, nb::device::cpu>;

const double *pointer(const nb::object &array) { return array.is_none() ? nullptr : nb::cast<In>(array).data(); }

void gradient(const Engine &engine, In time, In z, int columns, Index offsets, nb::object sensor, nb::object noise, bool full_noise,
              nb::object input, nb::object prior_x, nb::object prior_P, Figure figure, int ahead, const std::vector<int> &components,
              nb::object target, nb::object weight, In tangents, Out value, Out slope, int threads) {
    BatchInput in{time.data(), z.data(), columns, offsets.data(), std::int64_t(offsets.size()) - 1};
    if (!sensor.is_none()) in.sensor = nb::cast<Sensors>(sensor).data();
    in.noise = pointer(noise), in.full_noise = full_noise, in.input = pointer(input);
    in.prior_x = pointer(prior_x), in.prior_P = pointer(prior_P);
    const Objective objective{figure, ahead, components, pointer(target), pointer(weight)};
    nb::gil_scoped_release released;
    run_gradient(engine.pack->declared, in, objective, tangents.data(), int(tangents.shape(0)), value.data(), slope.data(), threads);
}

}  // namespace

void bind_gradient(nb::module_ &module) {
    nb::enum_<Figure>(module, "Figure", "Which figure of a filter is differentiated.")
        .value("log_likelihood", Figure::log_likelihood)
        .value("prediction_error", Figure::prediction_error)
        .value("tracking_error", Figure::tracking_error);
    module.def("numbers", [](const Engine &engine) { return numbers_of(engine.pack->declared); }, "engine"_a,
               "The numbers the filter can be differentiated by.");
    module.def("differentiable", [](const Engine &engine) { return differentiable(engine.pack->declared); }, "engine"_a,
               "Whether the filter's figures have derivatives by them.");
    module.def("gradient", gradient, "engine"_a, "time"_a, "z"_a, "columns"_a, "offsets"_a, "sensor"_a.none(), "noise"_a.none(), "full_noise"_a,
               "input"_a.none(), "prior_x"_a.none(), "prior_P"_a.none(), "figure"_a, "ahead"_a, "components"_a, "target"_a.none(),
               "weight"_a.none(), "tangents"_a, "value"_a, "slope"_a, "threads"_a,
               "Sums of a figure per track into value (tracks, sums), their derivatives along the tangents into slope.");
}
