// The Python face of live tracks: one target or many, a scan at a time.
#include <nanobind/stl/string.h>

#include "bindings/live_checks.hpp"
#include "bindings/live_results.hpp"

namespace {

struct Estimate : Snapshot<double> {
    std::shared_ptr<const Composition<double>> c;
    Status status = Status::none;
};

// The mean, and unless null the packed covariance, in the reported components.
void combined(const Estimate &e, double *x, double *P) {
    Combine<double> combine(*e.c);
    combine(e.arena.data(), e.probability.data(), x, P);
    corrected(e.correction, x, P);
}

// A NumPy array of this shape, and where its numbers go. Through numpy.empty itself, which is twice as fast as a capsule of ours.
template <class... Sizes> nb::object new_array(double *&data, Sizes... sizes) {
    static PyObject *empty = nb::object(nb::module_::import_("numpy").attr("empty")).release().ptr();
    nb::object shape = nb::make_tuple(sizes...);
    nb::object array = nb::steal(PyObject_CallOneArg(empty, shape.ptr()));
    Py_buffer view;
    if (!array.is_valid() || PyObject_GetBuffer(array.ptr(), &view, PyBUF_WRITABLE) != 0) throw nb::python_error();
    data = static_cast<double *>(view.buf);
    PyBuffer_Release(&view);  // the array keeps its memory
    return array;
}

nb::object estimate_array(const Estimate &e, bool covariance) {
    const int n = e.c->reported.n;
    double *to, x[largest_state], P[packed_size(largest_state)];
    combined(e, x, covariance ? P : nullptr);
    nb::object array = covariance ? new_array(to, n, n) : new_array(to, n);
    for (int r = 0; r < n; ++r)
        if (!covariance) to[r] = e.started ? x[r] : NAN;
        else
            for (int q = 0; q < n; ++q) to[r * n + q] = e.started ? P[packed(r, q)] : NAN;
    return array;
}

// Of the reported components: px vx (ax) py … turn_rate.
std::vector<std::string> component_names(const StateShape &s) {
    std::vector<std::string> names;
    for (int a = 0; a < s.axes; ++a)
        for (int k = 0; k < s.block; ++k) names.push_back({"pva"[k], "xyz"[a]});
    if (s.turn) names.push_back("turn_rate");
    return names;
}

int component(const Estimate &e, const std::string &name) {
    const std::vector<std::string> names = component_names(e.c->reported);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return int(found - names.begin());
    std::string message = "'" + name + "': expected one of ";
    for (const std::string &known : names) message += (&known == &names[0] ? "" : ", ") + known;
    throw nb::key_error(message.c_str());
}

// Seconds from a Python number, or through the package from a date.
double seconds(nb::handle t) {
    const double value = PyFloat_AsDouble(t.ptr());
    if (value != -1.0 || !PyErr_Occurred()) return value;
    PyErr_Clear();
    double date;
    if (!nb::try_cast(nb::module_::import_("jink.times").attr("seconds")(t), date)) throw nb::type_error("t: expected one time");
    return date;
}

nb::builtin_exception wrong_count(int columns, size_t got) {
    return nb::value_error(("z: expected " + std::to_string(columns) + " components, as the sensor measures, got " + std::to_string(got)).c_str());
}

// One component. A number of the user's own may run code.
double component_of(nb::handle item) {
    const double value = PyFloat_AsDouble(item.ptr());
    if (value != -1.0 || !PyErr_Occurred()) return value;
    PyErr_Clear();
    throw nb::type_error("z: expected numbers, NaN or None");
}

// A measurement's components from a number, a sequence (None is missing) or an array.
void components(nb::handle z, int columns, double *to) {
    if (PyFloat_Check(z.ptr()) || PyLong_Check(z.ptr())) {
        if (columns != 1) throw wrong_count(columns, 1);
        *to = component_of(z);
        return;
    }
    if (z.is_none()) {
        std::fill(to, to + columns, NAN);
        return;
    }
    if (PyTuple_Check(z.ptr()) || PyList_Check(z.ptr())) {
        if (PySequence_Size(z.ptr()) != columns) throw wrong_count(columns, size_t(PySequence_Size(z.ptr())));
        for (int r = 0; r < columns; ++r) {
            // such code can make a list shorter
            if (Py_SIZE(z.ptr()) != columns) throw wrong_count(columns, size_t(Py_SIZE(z.ptr())));
            const nb::object item = nb::borrow(PyTuple_Check(z.ptr()) ? PyTuple_GET_ITEM(z.ptr(), r) : PyList_GET_ITEM(z.ptr(), r));
            to[r] = item.is_none() ? NAN : component_of(item);
        }
        return;
    }
    Py_buffer view;
    if (PyObject_GetBuffer(z.ptr(), &view, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) == 0) {  // the usual case, without nanobind's detour
        const bool doubles = view.format && std::strcmp(view.format, "d") == 0 && view.len == Py_ssize_t(columns * sizeof(double));
        if (doubles) std::memcpy(to, view.buf, view.len);
        PyBuffer_Release(&view);
        if (doubles) return;
    } else {
        PyErr_Clear();
    }
    Const array;
    if (!nb::try_cast(z, array)) throw nb::type_error("z: expected numbers, a sequence or an array of floats");
    if (int(array.size()) != columns) throw wrong_count(columns, array.size());
    std::copy(array.data(), array.data() + columns, to);
}

Const floats(const char *name, const nb::object &given) {
    Const array;
    if (!nb::try_cast(given, array)) throw nb::type_error((name + std::string(": expected an array of floats")).c_str());
    return array;
}

class LiveOne : public Live<double> {
  public:
    using Live<double>::Live;

    nb::object filter;  // what it was started by, for copies

    Estimate update_one(nb::handle t, nb::handle z, int sensor, nb::object noise, nb::object input) {
        const int columns = c->declared.columns();
        double values[largest_measurement];
        const double time = seconds(t);
        components(z, columns, values);
        check_time(time);
        if (started(0) && time < time_of(0)) throw nb::value_error("t: lies before the last update; updates must come in the order of time");
        if (const int last = int(c->sensors.size()) - 1; sensor < 0 || sensor > last)
            throw nb::value_error(("sensor: expected an index from 0 to " + std::to_string(last) + ", got " + std::to_string(sensor)).c_str());
        for (int r = 0; r < columns; ++r)
            if (std::isinf(values[r])) throw nb::value_error("z: is infinite; a missing component is NaN or None");
        Rows rows{&time, true, values};
        rows.one_sensor = sensor;
        Const R, u;
        if (!noise.is_none()) {
            R = floats("covariance", noise);
            check_noise(R, columns);
            rows.noise = R.data(), rows.full_noise = R.ndim() == 2;
        }
        if (!input.is_none()) {
            u = floats("input", input);
            check_input(u, c->declared.axes());
            rows.input = u.data();
        }
        Estimate e;
        const std::lock_guard lock(busy);
        Live<double>::update(0, rows, with_nis, e);
        e.c = c;
        e.status = !e.started ? Status::none
                   : e.outcome.initialised ? (e.outcome.restarted ? Status::restarted : Status::initialised)
                   : e.outcome.gated ? Status::gated
                   : e.outcome.measured ? Status::updated : Status::predicted;
        return e;
    }

    Estimate predict_one(nb::handle t) {
        Estimate e;
        const double time = seconds(t);
        check_time(time);
        const std::lock_guard lock(busy);
        Live<double>::predict(0, &time, true, e);
        e.c = c, e.status = e.started ? Status::predicted : Status::none;
        return e;
    }
};

class LiveMany : public Live<Pack> {
  public:
    using Live<Pack>::Live;

    // Writes x, P, mode probability, log-likelihood, NIS, its degrees of freedom, time and status of every target.
    void update_all(const Const t, const Const z, nb::object sensor, nb::object noise, nb::object input, nb::list results, bool predict_only) {
        if (t.size() != 1 && t.size() != std::size_t(targets())) throw wrong("t: expected one time or one for each target");
        for (std::size_t k = 0; k < t.size(); ++k) check_time(t.data()[k]);
        const To to(results);
        Rows rows{t.data(), t.size() == 1, z.data()};
        nb::ndarray<const std::int32_t, nb::c_contig> which;
        Const R, u;
        if (!sensor.is_none()) which = nb::cast<decltype(which)>(sensor), rows.sensor = which.data();
        if (!noise.is_none()) R = nb::cast<Const>(noise), rows.noise = R.data(), rows.full_noise = R.ndim() == 3;
        if (!input.is_none()) u = nb::cast<Const>(input), rows.input = u.data();
        nb::gil_scoped_release released;
        const std::lock_guard lock(busy);
        Combine<Pack> combine(*c);
        scan(rows, 0, predict_only, combine, to);
    }

    // Scan after scan: t one time for each, z and noise those of all targets, scan by scan, and so are the results.
    void follow(const Const t, const Const z, nb::object noise, nb::list results) {
        const int columns = c->declared.columns(), scans = int(t.size());
        if (z.size() != std::size_t(scans) * targets() * columns) throw wrong("z: expected one row for each scan and target");
        for (int k = 0; k < scans; ++k) check_time(t.data()[k]);
        const To to(results);
        Const R;
        if (!noise.is_none()) R = nb::cast<Const>(noise);
        const bool full = !noise.is_none() && R.ndim() == 3;
        nb::gil_scoped_release released;
        const std::lock_guard lock(busy);
        Combine<Pack> combine(*c);
        for (int k = 0; k < scans; ++k) {
            const std::size_t first = std::size_t(k) * targets();
            Rows rows{t.data() + k, true, z.data() + first * columns};
            if (!noise.is_none()) rows.noise = R.data() + first * (full ? columns * columns : columns), rows.full_noise = full;
            scan(rows, int(first), false, combine, to);
        }
    }

  private:
    // Where results go; null where not wanted.
    struct To {
        double *numbers[7] = {};
        unsigned char *status;

        explicit To(const nb::list &results) {
            for (int k = 0; k < 7; ++k)
                if (!results[k].is_none()) numbers[k] = nb::cast<Doubles>(results[k], false).data();
            status = nb::cast<nb::ndarray<unsigned char, nb::c_contig>>(results[7], false).data();
        }
    };

    // One scan of all targets; `first` is the row of the first target's results.
    void scan(const Rows &rows, int first, bool predict_only, Combine<Pack> &combine, const To &to) {
        for (int p = 0; p < packs(); ++p) {
            if (predict_only) Live<Pack>::predict(p, rows.time, rows.one_time, left);
            else Live<Pack>::update(p, rows, to.numbers[4] ? with_nis : plain, left);
            write_results(*c, left, combine, first + p * lanes, std::min(lanes, targets() - p * lanes), to.numbers, to.status);
        }
    }

    Snapshot<Pack> left;  // by the scan of a pack
};

template <class L> nb::bytes save_state(const L &live) {
    const std::lock_guard lock(live.busy);
    const std::string state = live.save();
    return nb::bytes(state.data(), state.size());
}

template <class L> void restore_state(L &live, nb::bytes state) {
    const std::lock_guard lock(live.busy);
    live.restore(state.c_str(), state.size());
}

template <class L> void begin_at(L &live, int target, Const x, Const P, double time) {
    check_target(target, live.targets());
    check_state(x, P, time, live.c->reported.n);
    const std::lock_guard lock(live.busy);
    live.begin(target, x.data(), P.data(), time);
}

template <class L> void reset_at(L &live, int target) {
    check_target(target, live.targets());
    const std::lock_guard lock(live.busy);
    live.reset(target);
}

template <class L> double time_at(const L &live, int target) {
    check_target(target, live.targets());
    const std::lock_guard lock(live.busy);
    return live.time_of(target);
}

const char *status_name(Status s) {
    static const char *names[] = {"none", "updated", "predicted", "gated", "restarted", "initialised"};
    return names[int(s)];
}

}  // namespace

void bind_live(nb::module_ &module, nb::class_<Engine> &engine) {
    engine
        .def("one", [](const Engine &e, int lag, nb::object filter) {
            auto *live = new LiveOne(e.scalar, 1, lag);
            live->filter = std::move(filter);
            return live;
        }, "lag"_a, "filter"_a = nb::none())
        .def("many", [](const Engine &e, int n, int lag) { return new LiveMany(e.pack, n, lag); });

    nb::class_<Estimate>(module, "Estimate")
        .def_prop_ro("time", [](const Estimate &e) { return e.time; })
        .def_prop_ro("x", [](const Estimate &e) { return estimate_array(e, false); })
        .def_prop_ro("P", [](const Estimate &e) { return estimate_array(e, true); })
        .def_prop_ro("mode_probability",
                     [](const Estimate &e) {
                         double *to;
                         const std::vector<double> probability = set_probability(*e.c, e);
                         nb::object array = new_array(to, probability.size());
                         for (std::size_t j = 0; j < probability.size(); ++j) to[j] = e.started ? probability[j] : NAN;
                         return array;
                     })
        .def_prop_ro("log_likelihood", [](const Estimate &e) { return e.outcome.log_likelihood; })
        .def_prop_ro("nis", [](const Estimate &e) { return e.outcome.scored ? e.outcome.nis : NAN; })
        .def_prop_ro("nis_dof", [](const Estimate &e) { return e.outcome.scored ? e.outcome.dof : 0.0; })
        .def_prop_ro("status", [](const Estimate &e) { return status_name(e.status); })
        .def_prop_ro("doubt", [](const Estimate &e) { return e.doubt; }, "Probability that the measurement is an outlier, where the next one decides; else 0.")
        .def_prop_ro("decided",
                     [](const Estimate &e) -> nb::object {
                         if (!e.outcome.decided) return nb::none();
                         return nb::str(status_name(e.outcome.upheld ? Status::updated : Status::gated));
                     },
                     nb::sig("def decided(self) -> str | None"), "The status of the measurement before, if that was in doubt until now.")
        .def_prop_ro("components",
                     [](const Estimate &e) {
                         nb::list names;
                         for (const std::string &name : component_names(e.c->reported)) names.append(nb::str(name.c_str()));
                         return nb::tuple(names);
                     })
        .def(
            "__getitem__",
            [](const Estimate &e, const std::string &name) {
                double x[largest_state];
                const int at = component(e, name);
                combined(e, x, nullptr);
                return e.started ? x[at] : NAN;
            },
            "component"_a, "One component's estimate, by name.")
        .def(
            "sd",
            [](const Estimate &e, const std::string &name) {
                double x[largest_state], P[packed_size(largest_state)];
                const int at = component(e, name);
                combined(e, x, P);
                return e.started ? std::sqrt(P[packed(at, at)]) : NAN;
            },
            "component"_a, "One component's standard deviation, by name.")
        .def("__repr__", [](const Estimate &e) {
            std::string names;
            for (const std::string &name : component_names(e.c->reported)) names += " " + name;
            return "Estimate(" + std::string(status_name(e.status)) + " at " + std::to_string(e.time) + " s;" + names + ")";
        });

    nb::class_<LiveOne>(module, "LiveOne")
        .def("update", &LiveOne::update_one, "t"_a, "z"_a.none(), "sensor"_a = 0, "covariance"_a = nb::none(), "input"_a = nb::none(),
             "One measurement at time t; returns the estimate it leads to. A missing z is None, a missing component NaN or None.")
        .def("predict", &LiveOne::predict_one, "t"_a, "The estimate expected at time t; the live state is not touched.")
        .def("begin", [](LiveOne &live, Const x, Const P, double time) { begin_at(live, 0, x, P, time); }, "x"_a, "P"_a, "time"_a,
             "Start from a given state at a time.")
        .def("reset", [](LiveOne &live) { reset_at(live, 0); }, "Forget the target; the next position starts a new one.")
        .def("save", save_state<LiveOne>, "The state as bytes, the same on every machine.")
        .def("restore", restore_state<LiveOne>, "state"_a, "Take up a saved state.")
        .def("__reduce__", [](nb::handle self) {
            const LiveOne &live = nb::cast<const LiveOne &>(self);
            if (live.filter.is_none()) throw nb::type_error("a live target without its filter cannot be copied");
            return nb::make_tuple(nb::module_::import_("jink.filters.live").attr("started"), nb::make_tuple(live.filter, live.lag_scans(), save_state(live)));
        });

    nb::class_<LiveMany>(module, "LiveMany")
        .def("update", &LiveMany::update_all, "t"_a, "z"_a, "sensor"_a.none(), "noise"_a.none(), "input"_a.none(), "results"_a, "predict_only"_a)
        .def("follow", &LiveMany::follow, "t"_a, "z"_a, "noise"_a.none(), "results"_a)
        .def("begin", begin_at<LiveMany>, "target"_a, "x"_a, "P"_a, "time"_a)
        .def("reset", reset_at<LiveMany>, "target"_a)
        .def("time", time_at<LiveMany>)
        .def("save", save_state<LiveMany>)
        .def("restore", restore_state<LiveMany>, "state"_a);
}
