// The Python face of many targets in clutter: association rules, and the tracker that takes whole scans.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "associate/many.hpp"
#include "bindings/bindings.hpp"

namespace {

using Integers = nb::ndarray<const std::int64_t, nb::c_contig, nb::device::cpu>;

Edges edges_of(Integers begin, Integers plot, Const value, int plots) {
    Edges edges;
    edges.plots = plots;
    edges.begin.assign(begin.data(), begin.data() + begin.size());
    edges.plot.assign(plot.data(), plot.data() + plot.size());
    edges.value.assign(value.data(), value.data() + value.size());
    return edges;
}

// Of each edge, row and plot, and the most sweeps of any cluster (0: exact).
nb::tuple marginals(Integers begin, Integers plot, Const value, int plots, bool exactly, double tolerance, int sweeps) {
    const Edges psi = edges_of(begin, plot, value, plots);
    Marginals found;
    ByPlot by;
    Clusters clusters;
    BeliefPropagation beliefs;
    ExactMarginals exact;
    beliefs.tolerance = tolerance, beliefs.sweeps = sweeps;
    found.clear(psi), by.take(psi), clusters.take(psi), beliefs.prepare(psi, by);
    int most = 0;
    for (int k = 0; k < clusters.count(); ++k) {
        const int *rows = &clusters.row[clusters.begin[k]], n = clusters.begin[k + 1] - clusters.begin[k];
        if (exactly && exact(psi, rows, n, found)) continue;
        most = std::max(most, beliefs(psi, rows, n, found));
    }
    return nb::make_tuple(found.hit, found.miss, found.lone, most);
}

// Logarithm of the sum over all assignments of the product of their weights, by belief propagation.
double log_total(Integers begin, Integers plot, Const value, int plots) {
    const Edges psi = edges_of(begin, plot, value, plots);
    Marginals found;
    ByPlot by;
    Clusters clusters;
    BeliefPropagation beliefs;
    beliefs.weigh_all = true;
    found.clear(psi), by.take(psi), clusters.take(psi), beliefs.prepare(psi, by);
    for (int k = 0; k < clusters.count(); ++k) beliefs(psi, &clusters.row[clusters.begin[k]], clusters.begin[k + 1] - clusters.begin[k], found);
    return beliefs.log_total;
}

std::vector<int> assign(Integers begin, Integers plot, Const cost, int plots) {
    Assignment assignment;
    assignment(edges_of(begin, plot, cost, plots));
    return assignment.plot_of;
}

std::vector<int> cluster(Integers begin, Integers plot, int plots) {
    Edges edges;
    edges.plots = plots;
    edges.begin.assign(begin.data(), begin.data() + begin.size());
    edges.plot.assign(plot.data(), plot.data() + plot.size());
    Clusters clusters;
    clusters.take(edges);
    std::vector<int> of(edges.rows(), -1);
    for (int k = 0; k < clusters.count(); ++k)
        for (int r = clusters.begin[k]; r < clusters.begin[k + 1]; ++r) of[clusters.row[r]] = k;
    return of;
}

nb::dict report_of(const ScanReport &r) {
    nb::dict out;
    out["plots"] = r.plots, out["unusable"] = r.unusable, out["born"] = r.born, out["dropped"] = r.dropped, out["merged"] = r.merged;
    out["living"] = r.living, out["confirmed"] = r.confirmed;
    if (!std::isnan(r.log_likelihood)) out["log_likelihood"] = r.log_likelihood;
    out["sure"] = r.sure, out["seen"] = r.seen;
    out["handed"] = nb::cast(r.handed);
    out["crowded"] = r.crowded, out["full"] = r.full, out["inexact"] = r.inexact;
    return out;
}

nb::dict scan(Many &many, double time, int sensor, Const z, nb::object noise, nb::object unit, nb::object code, nb::object times, nb::object sector) {
    PlotRows rows;
    Sector part;
    Integers waits;
    rows.count = int(z.shape(0)), rows.columns = int(z.shape(1)), rows.z = z.data();
    Const R, u, own;
    Integers codes;
    if (!noise.is_none()) R = nb::cast<Const>(noise), rows.noise = R.data(), rows.full_noise = R.ndim() == 3;
    if (!unit.is_none()) u = nb::cast<Const>(unit), rows.unit = u.data();
    if (!code.is_none()) codes = nb::cast<Integers>(code), rows.code = codes.data();
    if (!times.is_none()) own = nb::cast<Const>(times), rows.time = own.data();
    if (!sector.is_none()) {
        const auto given = nb::cast<nb::tuple>(sector);
        part.period = nb::cast<double>(given[0]), part.from = nb::cast<double>(given[1]), part.to = nb::cast<double>(given[2]);
        part.part = nb::cast<double>(given[3]), part.last = nb::cast<bool>(given[4]);
        waits = nb::cast<Integers>(given[5]), rows.waiting = waits.data();
    }
    ScanReport report;
    {
        nb::gil_scoped_release released;
        report = many.scan(time, sensor, rows, part);
    }
    return report_of(report);
}

// The tracks of at least this existence, those confirmed in any case, by id.
nb::dict tracks(Many &many, double least, bool covariance) {
    const Pool &pool = many.pool;
    const int n = many.c->reported.n, m = many.c->count;
    std::vector<std::pair<std::int64_t, int>> order;
    for (int s = 0; s < pool.slots(); ++s) {
        const Life &one = pool.life[s];
        if (pool.live(s) && (one.confirmed || one.existence >= least)) order.push_back({one.id, s});
    }
    std::vector<int> place(pool.slots(), -1);
    std::sort(order.begin(), order.end());
    const std::size_t count = order.size();
    std::vector<std::int64_t> id(count), plot(count), age(count), used(count);
    std::vector<double> existence(count), time(count), x(count * n), P(covariance ? count * n * n : 0), mu(count * m);
    std::vector<unsigned char> status(count);
    std::vector<std::uint8_t> confirmed(count), due(count);
    for (std::size_t k = 0; k < count; ++k) {
        const Life &one = pool.life[order[k].second];
        place[order[k].second] = int(k);
        id[k] = one.id, plot[k] = one.plot, age[k] = one.age, used[k] = one.plots;
        existence[k] = one.existence, confirmed[k] = one.confirmed, due[k] = one.due;
        // What more probably had no plot is predicted.
        if (!(one.share > 0.5)) plot[k] = -1;
        status[k] = static_cast<unsigned char>(one.age == 0 ? Status::initialised : one.share > 0.5 ? Status::updated : Status::predicted);
    }
    Combine<Pack> combine(*many.c);
    Pack mean[largest_state], spread[packed_size(largest_state)];
    for (std::size_t p = 0; p < pool.packs.size(); ++p) {
        const TrackState<Pack> &s = pool.packs[p].state;
        if (std::none_of(&place[p * lanes], &place[p * lanes] + lanes, [](int k) { return k >= 0; })) continue;
        combine(s.arena.data(), s.probability.data(), mean, covariance ? spread : nullptr);
        for (int l = 0; l < lanes; ++l) {
            const int k = place[p * lanes + l];
            if (k < 0) continue;
            time[k] = s.time[l];
            for (int r = 0; r < n; ++r) x[std::size_t(k) * n + r] = mean[r][l];
            for (int r = 0; r < n && covariance; ++r)
                for (int q = 0; q < n; ++q) P[(std::size_t(k) * n + r) * n + q] = spread[packed(r, q)][l];
            for (int j = 0; j < m; ++j) mu[std::size_t(k) * m + j] = s.probability[j][l];
        }
    }
    nb::dict out;
    const std::size_t N = n, M = m;
    out["id"] = array_of(std::move(id), {count}), out["plot"] = array_of(std::move(plot), {count});
    out["age"] = array_of(std::move(age), {count}), out["plots"] = array_of(std::move(used), {count});
    out["existence"] = array_of(std::move(existence), {count}), out["status"] = array_of(std::move(status), {count});
    out["confirmed"] = array_of(std::move(confirmed), {count}).attr("view")("bool");
    out["due"] = array_of(std::move(due), {count}).attr("view")("bool");
    out["time"] = array_of(std::move(time), {count});
    out["x"] = array_of(std::move(x), {count, N});
    if (covariance) out["P"] = array_of(std::move(P), {count, N, N});
    out["mode_probability"] = array_of(std::move(mu), {count, M});
    return out;
}

// Of the tracks that `tracks` gives, in its order: the plots of the last scan by weight (rows `begin[k]` to `begin[k + 1]`), and
// the covariance of the position that was predicted, NaN where the track has begun with this scan.
nb::dict taken(Many &many, double least) {
    const Pool &pool = many.pool;
    std::vector<std::pair<std::int64_t, int>> order;
    for (int s = 0; s < pool.slots(); ++s) {
        const Life &one = pool.life[s];
        if (pool.live(s) && (one.confirmed || one.existence >= least)) order.push_back({one.id, s});
    }
    std::sort(order.begin(), order.end());
    const std::size_t count = order.size(), axes = many.c->reported.axes, block = many.c->reported.block;
    std::vector<std::int64_t> begin{0}, row;
    std::vector<double> weight, spread(count * axes * axes, NAN);
    Combine<Pack> combine(*many.c);
    Pack mean[largest_state], P[packed_size(largest_state)];
    for (std::size_t k = 0; k < count; ++k) {
        const int s = order[k].second;
        for (const Share &each : many.taken(s)) row.push_back(each.plot), weight.push_back(each.weight);
        begin.push_back(std::int64_t(row.size()));
        if (pool.life[s].age == 0) continue;
        const TrackPack &pack = pool.packs[s / lanes];
        combine(pack.predicted.data(), pack.prior.data(), mean, P);
        for (std::size_t a = 0; a < axes; ++a)
            for (std::size_t b = 0; b < axes; ++b)
                spread[(k * axes + a) * axes + b] = P[packed(int(std::max(a, b) * block), int(std::min(a, b) * block))][s % lanes];
    }
    nb::dict out;
    const std::size_t edges = row.size();
    out["begin"] = array_of(std::move(begin), {count + 1}), out["row"] = array_of(std::move(row), {edges});
    out["weight"] = array_of(std::move(weight), {edges}), out["spread"] = array_of(std::move(spread), {count, axes, axes});
    return out;
}

nb::bytes save_state(const Many &many) {
    const Vector all = many.save();
    return nb::bytes(reinterpret_cast<const char *>(all.data()), all.size() * sizeof(double));
}

void restore_state(Many &many, nb::bytes state) {
    if (state.size() % sizeof(double)) throw nb::value_error("state: is cut short");
    Vector all(state.size() / sizeof(double));
    std::memcpy(all.data(), state.c_str(), state.size());
    many.restore(all);
}

void bind_rules(nb::module_ &module) {
    nb::enum_<Association>(module, "Association", "How plots are given to tracks.")
        .value("marginal", Association::marginal)
        .value("jpda", Association::jpda)
        .value("pda", Association::pda)
        .value("gnn", Association::gnn)
        .value("nearest", Association::nearest);
    nb::class_<SensorView>(module, "SensorView", "What a sensor sees of what is there, and what it sees that is not.")
        .def(nb::init<>())
        .def_rw("detection", &SensorView::detection)
        .def_rw("clutter", &SensorView::clutter)
        .def_rw("undetected", &SensorView::undetected)
        .def_rw("arrivals", &SensorView::arrivals)
        .def_rw("reach", &SensorView::reach)
        .def_rw("area", &SensorView::area)
        .def_rw("scanning", &SensorView::scanning)
        .def_rw("learning", &SensorView::learning)
        .def_ro("scans", &SensorView::scans)
        .def("within", [](SensorView &v, double x0, double x1, double y0, double y1) { v.low[0] = x0, v.high[0] = x1, v.low[1] = y0, v.high[1] = y1; })
        .def("around", [](SensorView &v, double x, double y, double reach) { v.site[0] = x, v.site[1] = y, v.reach = reach; });
    nb::class_<ManyRules>(module, "ManyRules", "Gates and the life cycle of tracks.")
        .def(nb::init<>())
        .def_rw("association", &ManyRules::association)
        .def_rw("gate", &ManyRules::gate)
        .def_rw("split_gate", &ManyRules::split_gate)
        .def_rw("confirm", &ManyRules::confirm)
        .def_rw("keep", &ManyRules::keep)
        .def_rw("drop", &ManyRules::drop)
        .def_rw("life", &ManyRules::life)
        .def_rw("drop_after", &ManyRules::drop_after)
        .def_rw("established", &ManyRules::established)
        .def_rw("left", &ManyRules::left)
        .def_rw("abreast", &ManyRules::abreast)
        .def_rw("sure", &ManyRules::sure)
        .def_rw("inherit", &ManyRules::inherit)
        .def_rw("merge_within", &ManyRules::merge_within)
        .def_rw("merge_after", &ManyRules::merge_after)
        .def_rw("split", &ManyRules::split)
        .def_rw("unclaimed", &ManyRules::unclaimed)
        .def_rw("leave", &ManyRules::leave)
        .def_rw("patience", &ManyRules::patience)
        .def_rw("young", &ManyRules::young)
        .def_rw("crowd", &ManyRules::crowd)
        .def_rw("most_plots", &ManyRules::most_plots)
        .def_rw("most_tracks", &ManyRules::most_tracks)
        .def_rw("likelihood", &ManyRules::likelihood)
        .def_rw("threads", &ManyRules::threads);
}

}  // namespace

void bind_association(nb::module_ &module, nb::class_<Engine> &engine) {
    module.def("marginals", marginals, "begin"_a, "plot"_a, "psi"_a, "plots"_a, "exactly"_a = false, "tolerance"_a = 1e-4, "sweeps"_a = 200,
               "Marginals of sparse association weights: of each edge, of each row without a plot, of each plot without a row, and sweeps.");
    module.def("log_total", log_total, "begin"_a, "plot"_a, "psi"_a, "plots"_a,
               "Logarithm of the sum over all assignments of the product of their weights.");
    module.def("assign", assign, "begin"_a, "plot"_a, "cost"_a, "plots"_a, "The plot of each row, or -1, at the least total cost; a row without costs 0.");
    module.def("cluster", cluster, "begin"_a, "plot"_a, "plots"_a, "Which cluster each row is in, or -1.");
    bind_rules(module);
    nb::class_<Many>(module, "Many", "Many targets from plots without identity.")
        .def("scan", scan, "time"_a, "sensor"_a, "z"_a, "noise"_a.none(), "unit"_a.none(), "code"_a.none(), "times"_a.none(), "sector"_a.none() = nb::none())
        .def("tracks", tracks, "least"_a, "covariance"_a)
        .def("taken", taken, "least"_a)
        .def("add", [](Many &many, double time, Const x, Const P, double existence) { return many.add(time, x.data(), P.data(), existence); })
        .def("view", [](Many &many, int sensor) { return many.sensors.at(sensor); })
        .def("set_view", [](Many &many, int sensor, const SensorView &view) { many.sensors.at(sensor) = view; })
        .def("lone", [](const Many &many) { return array_of(std::vector<double>(many.lone), {many.lone.size()}); })
        .def_ro("time", &Many::time)
        .def("living", [](const Many &many) { return many.pool.living(); })
        .def("save", save_state)
        .def("restore", restore_state, "state"_a);
    engine.def("association", [](const Engine &e, const ManyRules &rules, const std::vector<SensorView> &sensors) { return new Many(e.pack, rules, sensors); },
               "rules"_a, "sensors"_a);
}
