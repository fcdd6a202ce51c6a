// The Python face of the native engine: private to the package, which checks its arguments before they come here.
#include "bindings/bindings.hpp"
#include "scan/limits.hpp"

namespace {

const double *pointer(const nb::object &array) { return array.is_none() ? nullptr : nb::cast<Const>(array).data(); }
double *target(const nb::object &array) { return array.is_none() ? nullptr : nb::cast<Doubles>(array, false).data(); }

void run(const Engine &engine, nb::ndarray<const double, nb::c_contig> time, nb::ndarray<const double, nb::c_contig> z, int columns,
         nb::ndarray<const std::int64_t, nb::c_contig> offsets, nb::object sensor, nb::object noise, bool full_noise, nb::object input,
         nb::object prior_x, nb::object prior_P, nb::list results, nb::object status, nb::list covariances, bool smooth, nb::object until,
         int threads) {
    BatchInput in{time.data(), z.data(), columns, offsets.data(), std::int64_t(offsets.size()) - 1};
    if (!sensor.is_none()) in.sensor = nb::cast<nb::ndarray<const std::int32_t, nb::c_contig>>(sensor).data();
    if (nb::isinstance<nb::list>(noise)) in.noise_columns = noise_columns_of(nb::cast<nb::list>(noise), columns, time.size());
    else in.noise = pointer(noise);
    in.full_noise = full_noise, in.input = pointer(input);
    in.prior_x = pointer(prior_x), in.prior_P = pointer(prior_P);
    if (!until.is_none()) in.until = nb::cast<nb::ndarray<const std::int64_t, nb::c_contig>>(until).data();
    BatchOutput out;
    double **slots[] = {&out.x, &out.P, &out.mode_probability, &out.log_likelihood, &out.log_likelihood_scan, &out.nis, &out.nis_dof, &out.pit};
    for (int k = 0; k < 8; ++k) *slots[k] = target(nb::object(results[k]));
    if (!status.is_none()) out.status = nb::cast<nb::ndarray<unsigned char, nb::c_contig>>(status, false).data();
    for (nb::handle each : covariances) out.covariances.push_back({nb::cast<int>(each[0]), nb::cast<int>(each[1]), target(nb::object(each[2]))});
    nb::gil_scoped_release released;
    run_batch(*engine.pack, in, out, smooth, threads);
}

}  // namespace

NB_MODULE(JINK_MODULE, module) {
    // what lives until the process ends is no leak: the command line looks for no garbage then
    nb::set_leak_warnings(false);
    bind_declarations(module);
    bind_stepwise(module);
    bind_population(module);
    bind_gradient(module);
    bind_checks(module);
    bind_scatter(module);
    bind_manoeuvres(module);
    bind_geodesy(module);
    bind_text(module);
    module.attr("lanes") = lanes;

    nb::class_<Engine> engine(module, "Engine");
    engine
        .def("__init__",
             [](Engine *self, const Declaration &d) {
                 check_limits(d);
                 new (self) Engine{std::make_shared<Composition<Pack>>(d), std::make_shared<Composition<double>>(d)};
             },
             "declaration"_a)
        .def("run", run, "time"_a, "z"_a, "columns"_a, "offsets"_a, "sensor"_a.none(), "noise"_a.none(), "full_noise"_a, "input"_a.none(),
             "prior_x"_a.none(), "prior_P"_a.none(), "results"_a, "status"_a.none(), "covariances"_a, "smooth"_a, "until"_a.none(), "threads"_a);
    bind_live(module, engine);
    bind_slots(module, engine);
    bind_association(module, engine);
}
