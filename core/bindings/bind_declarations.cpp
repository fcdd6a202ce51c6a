// The declaration of a filter for Python: enumerations and named fields, so that both sides use one set of names.
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include "bindings/bindings.hpp"
#include "scan/track.hpp"

namespace {

template <class E> using Names = std::initializer_list<std::pair<const char *, E>>;

template <class E> void enumeration(nb::module_ &module, const char *name, const char *doc, Names<E> values) {
    nb::enum_<E> bound(module, name, doc);
    for (const auto &[label, value] : values) bound.value(label, value);
}

void bind_enumerations(nb::module_ &module) {
    enumeration<Status>(module, "Status", "What became of a row: the numbers of jink.Status.",
                        {{"none", Status::none},
                         {"updated", Status::updated},
                         {"predicted", Status::predicted},
                         {"gated", Status::gated},
                         {"restarted", Status::restarted},
                         {"initialised", Status::initialised}});
    enumeration<MotionKind>(module, "MotionKind", "Which motion model moves a state.",
                            {{"constant_velocity", MotionKind::constant_velocity},
                             {"constant_acceleration", MotionKind::constant_acceleration},
                             {"singer", MotionKind::singer},
                             {"coordinated_turn", MotionKind::coordinated_turn},
                             {"known_turn", MotionKind::known_turn},
                             {"current_statistical", MotionKind::current_statistical},
                             {"augmented", MotionKind::augmented},
                             {"two_stage", MotionKind::two_stage},
                             {"statistical_along_track", MotionKind::statistical_along_track},
                             {"velocity_along_track", MotionKind::velocity_along_track}});
    enumeration<NoiseKind>(module, "NoiseKind", "Process noise: constant over a step (sd), or white (psd).",
                           {{"piecewise", NoiseKind::piecewise}, {"continuous", NoiseKind::continuous}});
    enumeration<SensorKind>(module, "SensorKind", "What a sensor measures.",
                            {{"position", SensorKind::position},
                             {"position_velocity", SensorKind::position_velocity},
                             {"bearing", SensorKind::bearing},
                             {"polar", SensorKind::polar}});
    enumeration<Vertical>(module, "Vertical", "What a polar sensor measures of the vertical.",
                          {{"none", Vertical::none}, {"elevation", Vertical::elevation}, {"height", Vertical::height}});
    enumeration<Start>(module, "Start", "How many points a track starts from.", {{"two_point", Start::two_point}, {"one_point", Start::one_point}, {"bounded_two_point", Start::bounded_two_point}});
    enumeration<Adapt>(module, "Adapt", "What sets a mode's process noise.",
                       {{"none", Adapt::none},
                        {"current_statistical", Adapt::current_statistical},
                        {"fuzzy_limits", Adapt::fuzzy_limits},
                        {"fuzzy_rules", Adapt::fuzzy_rules},
                        {"network", Adapt::network},
                        {"straight_limits", Adapt::straight_limits}});
    enumeration<Interaction>(module, "Interaction", "How the modes' past estimates interact.",
                             {{"imm", Interaction::imm}, {"none", Interaction::none}, {"gpb1", Interaction::gpb1}, {"gpb2", Interaction::gpb2}});
    enumeration<Propose>(module, "Propose", "Which modes are alive in a scan.",
                         {{"all", Propose::all},
                          {"digraph", Propose::digraph},
                          {"active", Propose::active},
                          {"grid", Propose::grid},
                          {"dimension", Propose::dimension}});
    enumeration<AidInputs>(module, "AidInputs", "What a learned correction looks at.",
                           {{"none", AidInputs::none}, {"residuals", AidInputs::residuals}, {"innovations", AidInputs::innovations},
                            {"sums", AidInputs::sums}, {"plane", AidInputs::plane}});
    enumeration<AidModel>(module, "AidModel", "A network, or the shape of an ANFIS's membership functions.",
                          {{"network", AidModel::network},
                           {"triangular", AidModel::triangular},
                           {"gaussian", AidModel::gaussian},
                           {"bell", AidModel::bell}});
}

// Are two modes of one motion model, and differ in numbers only?
bool alike(const ModeDeclaration &a, const ModeDeclaration &b) {
    return a.motion.kind == b.motion.kind && a.motion.noise == b.motion.noise && a.motion.turn_noise == b.motion.turn_noise &&
           a.motion.axes == b.motion.axes && a.prior_variance == b.prior_variance;
}

void bind_parts(nb::module_ &module) {
    nb::class_<AdaptDeclaration>(module, "Adaptation", "What sets a mode's process noise, or weighs the modes.")
        .def(nb::init<Adapt, std::vector<int>, bool, Vector>(), nb::kw_only(), "kind"_a = Adapt::none, "sizes"_a = std::vector<int>(),
             "logarithmic"_a = false, "numbers"_a = Vector())
        .def_ro("kind", &AdaptDeclaration::kind)
        .def_ro("numbers", &AdaptDeclaration::numbers);

    nb::class_<ModeDeclaration>(module, "Mode", "A motion model in numbers.")
        .def(
            "__init__",
            [](ModeDeclaration *self, MotionKind kind, int axes, const Vector &parameters, const Vector &prior_variance, NoiseKind noise,
               NoiseKind turn_noise) {
                new (self) ModeDeclaration{{kind, noise, turn_noise, axes}, shape_of(kind, axes), parameters, prior_variance, {}, {}, false, false};
            },
            nb::kw_only(), "kind"_a, "axes"_a, "parameters"_a, "prior_variance"_a, "noise"_a = NoiseKind::piecewise,
            "turn_noise"_a = NoiseKind::piecewise)
        .def_prop_ro("kind", [](const ModeDeclaration &m) { return m.motion.kind; })
        .def_prop_ro("noise", [](const ModeDeclaration &m) { return m.motion.noise; })
        .def_prop_ro("has_acceleration", [](const ModeDeclaration &m) { return m.shape.block == 3; })
        .def_prop_ro("has_turn_rate", [](const ModeDeclaration &m) { return m.shape.turn; })
        .def("alike", alike, "other"_a, "Of one motion model, so that they differ in numbers only?")
        .def_ro("prior_variance", &ModeDeclaration::prior_variance)
        .def_rw("parameters", &ModeDeclaration::parameters)
        .def_rw("adaptation", &ModeDeclaration::adapt)
        .def_rw("level", &ModeDeclaration::level)
        .def_rw("around_side", &ModeDeclaration::around_side)
        .def_rw("in_sd", &ModeDeclaration::in_sd);

    nb::class_<SensorDeclaration>(module, "Sensor", "A sensor in numbers: variances, or a packed covariance if correlated.")
        .def(
            "__init__",
            [](SensorDeclaration *self, SensorKind kind, int axes, int rows, const Vector &noise, const Vector &log_extent, bool correlated,
               Vertical vertical, bool range_rate, bool from_north, bool converted, std::array<double, 3> site, double radius) {
                const SensorSpec spec{kind, axes, rows, vertical, range_rate, from_north, correlated, {site[0], site[1], site[2]}, radius};
                new (self) SensorDeclaration{spec, converted, noise, log_extent};
            },
            nb::kw_only(), "kind"_a, "axes"_a, "rows"_a, "noise"_a, "log_extent"_a, "correlated"_a = false, "vertical"_a = Vertical::none,
            "range_rate"_a = false, "from_north"_a = true, "converted"_a = false, "site"_a = std::array<double, 3>{}, "radius"_a = 0.0)
        .def_prop_ro("kind", [](const SensorDeclaration &s) { return s.spec.kind; })
        .def_prop_ro("axes", [](const SensorDeclaration &s) { return s.spec.axes; })
        .def_prop_ro("rows", [](const SensorDeclaration &s) { return s.spec.rows; })
        .def_prop_ro("correlated", [](const SensorDeclaration &s) { return s.spec.correlated; })
        .def_prop_ro("vertical", [](const SensorDeclaration &s) { return s.spec.vertical; })
        .def_prop_ro("range_rate", [](const SensorDeclaration &s) { return s.spec.range_rate; })
        .def_prop_ro("from_north", [](const SensorDeclaration &s) { return s.spec.from_north; })
        .def_prop_ro("site", [](const SensorDeclaration &s) { return std::array<double, 3>{s.spec.site[0], s.spec.site[1], s.spec.site[2]}; })
        .def_prop_ro("radius", [](const SensorDeclaration &s) { return s.spec.radius; })
        .def_ro("converted", &SensorDeclaration::converted)
        .def_ro("noise", &SensorDeclaration::noise)
        .def_ro("log_extent", &SensorDeclaration::log_extent);

    nb::class_<ProposeDeclaration>(module, "Proposal", "Which modes of a large set are alive.")
        .def(nb::init<Propose, int, Vector, std::vector<std::vector<int>>, Vector>(), nb::kw_only(), "kind"_a = Propose::all, "slots"_a = 0,
             "start"_a = Vector(), "neighbours"_a = std::vector<std::vector<int>>(), "numbers"_a = Vector())
        .def_ro("kind", &ProposeDeclaration::kind);

    nb::class_<DetectDeclaration>(module, "Detection", "Input estimation beside one mode; window 0 for none.")
        .def(nb::init<int, int, double>(), nb::kw_only(), "window"_a = 0, "shortest"_a = 1, "threshold"_a = 0.0)
        .def_ro("window", &DetectDeclaration::window);

    nb::class_<CoastDeclaration>(module, "Coasting", "What a target does while nothing is measured; after 0: it goes on as it was.")
        .def(nb::init<double, double, double, bool>(), nb::kw_only(), "after"_a = 0.0, "manoeuvre"_a = 1.0, "climb"_a = 1.0, "reverses"_a = true)
        .def_ro("after", &CoastDeclaration::after)
        .def_ro("reverses", &CoastDeclaration::reverses);

    nb::class_<AidDeclaration>(module, "Aid", "A learned correction of what goes out.")
        .def(nb::init<AidInputs, AidModel, int, int, std::vector<int>, Vector>(), nb::kw_only(), "kind"_a = AidInputs::none,
             "model"_a = AidModel::network, "inputs"_a = 0, "outputs"_a = 0, "sizes"_a = std::vector<int>(), "numbers"_a = Vector())
        .def_ro("kind", &AidDeclaration::kind);
}

}  // namespace

void bind_declarations(nb::module_ &module) {
    bind_enumerations(module);
    bind_parts(module);
    nb::class_<Declaration>(module, "Declaration", "A whole filter, before it is made ready to run.")
        .def(nb::init<>())
        .def(nb::init<const Declaration &>(), "other"_a)
        .def_rw("modes", &Declaration::modes)
        .def_rw("sensors", &Declaration::sensors)
        .def_rw("continuous", &Declaration::continuous)
        .def_rw("transition", &Declaration::transition)
        .def_rw("initial_probability", &Declaration::initial_probability)
        .def_rw("unscented", &Declaration::unscented)
        .def_rw("unbiased_mixing", &Declaration::unbiased_mixing)
        .def_rw("outlier_share", &Declaration::outlier_share)
        .def_rw("restart_after", &Declaration::restart_after)
        .def_rw("hindsight", &Declaration::hindsight)
        .def_rw("coast", &Declaration::coast)
        .def_rw("coasting", &Declaration::coasting)
        .def_rw("start", &Declaration::start)
        .def_rw("velocity_variance", &Declaration::velocity_variance)
        .def_rw("interaction", &Declaration::interaction)
        .def_rw("side", &Declaration::side)
        .def_rw("proposal", &Declaration::propose)
        .def_rw("scores", &Declaration::scores)
        .def_rw("detection", &Declaration::detect)
        .def_rw("aid", &Declaration::aid)
        .def_prop_ro("columns", &Declaration::columns, "Of the measurement with the most components.");
}
