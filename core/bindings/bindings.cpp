// The Python face of the native engine: private to the package, which checks its arguments before they come here.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "run/batch.hpp"
#include "bindings/bindings.hpp"

namespace {

using Integers = std::vector<int>;
// kind of adaptation, layer sizes, in logarithms, numbers; level of known acceleration, about the side estimate
using AdaptTuple = std::tuple<int, Integers, bool, Vector>;
using ModeTuple = std::tuple<int, int, int, int, Vector, Vector, AdaptTuple, Vector, bool>;
using ProposeTuple = std::tuple<int, int, Vector, std::vector<Integers>, Vector>;
using AidTuple = std::tuple<int, int, int, int, Integers, Vector>;
using SensorTuple = std::tuple<int, int, int, int, bool, bool, bool, bool, Vector, Vector, Vector>;

AdaptDeclaration adapt_from(const AdaptTuple &t) {
    const auto &[kind, sizes, logarithmic, numbers] = t;
    return {Adapt(kind), sizes, logarithmic, numbers};
}

ModeDeclaration mode_from(const ModeTuple &t) {
    const auto &[kind, noise, turn_noise, axes, parameters, prior, adapt, level, around_side] = t;
    const auto motion = MotionKind(kind);
    const bool turn = motion == MotionKind::coordinated_turn;
    const int block = motion == MotionKind::constant_velocity || motion == MotionKind::known_turn || turn ? 2 : 3;
    return {{motion, NoiseKind(noise), NoiseKind(turn_noise), axes}, {axes, block, axes * block + turn, turn}, parameters, prior,
            adapt_from(adapt), level, around_side};
}

SensorDeclaration sensor_from(const SensorTuple &t) {
    const auto &[kind, axes, rows, vertical, range_rate, from_north, correlated, converted, site, noise, log_extent] = t;
    SensorSpec spec{SensorKind(kind), axes, rows, Vertical(vertical), range_rate, from_north, correlated, {site[0], site[1], site[2]}};
    return {spec, converted, noise, log_extent};
}

const double *pointer(const nb::object &array) { return array.is_none() ? nullptr : nb::cast<Const>(array).data(); }
double *target(const nb::object &array) { return array.is_none() ? nullptr : nb::cast<Doubles>(array).data(); }

void run(const Engine &engine, nb::ndarray<const double, nb::c_contig> time, nb::ndarray<const double, nb::c_contig> z, int columns,
         nb::ndarray<const std::int64_t, nb::c_contig> offsets, nb::object sensor, nb::object noise, bool full_noise, nb::object input,
         nb::object prior_x, nb::object prior_P, nb::list results, nb::object status, bool smooth, int threads) {
    BatchInput in{time.data(), z.data(), columns, offsets.data(), std::int64_t(offsets.size()) - 1};
    if (!sensor.is_none()) in.sensor = nb::cast<nb::ndarray<const std::int32_t, nb::c_contig>>(sensor).data();
    in.noise = pointer(noise), in.full_noise = full_noise, in.input = pointer(input);
    in.prior_x = pointer(prior_x), in.prior_P = pointer(prior_P);
    BatchOutput out;
    double **slots[] = {&out.x, &out.P, &out.mode_probability, &out.log_likelihood, &out.log_likelihood_scan, &out.nis, &out.nis_dof, &out.pit};
    for (int k = 0; k < 8; ++k) *slots[k] = target(nb::object(results[k]));
    if (!status.is_none()) out.status = nb::cast<nb::ndarray<unsigned char, nb::c_contig>>(status).data();
    nb::gil_scoped_release released;
    run_batch(*engine.pack, in, out, smooth, threads);
}

}  // namespace

NB_MODULE(JINK_MODULE, module) {
    bind_stepwise(module);
    bind_population(module);
    bind_gradient(module);
    module.attr("lanes") = lanes;

    nb::class_<Engine> engine(module, "Engine");
    engine
        .def("__init__",
             [](Engine *self, const std::vector<ModeTuple> &modes, const std::vector<SensorTuple> &sensors, bool continuous, const Vector &transition,
                const Vector &mode_probability, bool unscented, bool unbiased_mixing, double outlier_share, int restart_after, double coast,
                bool one_point, double velocity_variance, int interaction, const std::vector<ModeTuple> &side, const ProposeTuple &propose,
                const AdaptTuple &scores, std::tuple<int, int, double> detect, const AidTuple &aid) {
                 Declaration d;
                 for (const auto &m : modes) d.modes.push_back(mode_from(m));
                 for (const auto &s : sensors) d.sensors.push_back(sensor_from(s));
                 d.continuous = continuous, d.transition = transition, d.initial_probability = mode_probability;
                 d.unscented = unscented, d.unbiased_mixing = unbiased_mixing;
                 d.outlier_share = outlier_share, d.restart_after = restart_after, d.coast = coast;
                 d.start = one_point ? Start::one_point : Start::two_point, d.velocity_variance = velocity_variance;
                 d.interaction = Interaction(interaction);
                 for (const auto &m : side) d.side.push_back(mode_from(m));
                 d.propose = {Propose(std::get<0>(propose)), std::get<1>(propose), std::get<2>(propose), std::get<3>(propose), std::get<4>(propose)};
                 d.scores = adapt_from(scores), d.detect = {std::get<0>(detect), std::get<1>(detect), std::get<2>(detect)};
                 d.aid = {AidInputs(std::get<0>(aid)), AidModel(std::get<1>(aid)), std::get<2>(aid), std::get<3>(aid), std::get<4>(aid), std::get<5>(aid)};
                 new (self) Engine{std::make_shared<Composition<Pack>>(d), std::make_shared<Composition<double>>(d)};
             })
        .def("run", run, "time"_a, "z"_a, "columns"_a, "offsets"_a, "sensor"_a.none(), "noise"_a.none(), "full_noise"_a, "input"_a.none(),
             "prior_x"_a.none(), "prior_P"_a.none(), "results"_a, "status"_a.none(), "smooth"_a, "threads"_a);
    bind_live(module, engine);
}
