#include "associate/many.hpp"
#include "run/threads.hpp"

namespace jink::inline JINK_LEVEL {

template <class F> void Many::over_packs(F work) {
    const int packs = int(pool.packs.size());
    if (rules.threads <= 1 || packs < 16) {
        for (int p = 0; p < packs; ++p) work(*scanners[0], p);
        return;
    }
    std::atomic<int> next{0};
    over_threads(packs, rules.threads, [&] {
        return [&, scanner = scanners[next.fetch_add(1)].get()](std::int64_t p) { work(*scanner, int(p)); };
    });
}

// Positions of the plots, a pack at a time.
void Many::measure(const PlotRows &rows, int sensor, ScanReport &report) {
    const Sensor<Pack> &of = c->sensors[sensor];
    const int columns = c->declared.columns();
    std::vector<Fix<double>> positions(rows.count);
    const Step<Pack> &step = scanners[0]->step;
    for (int from = 0; from < rows.count; from += lanes) {
        Scan<Pack> scan;
        scan.active = splat_mask<Pack>(true);
        scan.own_noise = rows.noise != nullptr, scan.own_full = rows.full_noise;
        for (int r = 0; r < columns; ++r) scan.z[r] = nan_of<Pack>();
        for (int l = 0; l < lanes; ++l) {
            const std::int64_t j = std::min(from + l, rows.count - 1);
            for (int r = 0; r < rows.columns; ++r) scan.z[r][l] = rows.z[j * rows.columns + r];
            for (int r = 0; r < columns && rows.noise; ++r)
                for (int q = 0; q <= r; ++q) {
                    if (rows.full_noise) scan.R[packed(r, q)][l] = rows.noise[(j * columns + r) * columns + q];
                    else if (q == r) scan.R[r][l] = rows.noise[j * columns + r];
                }
        }
        Measurement<Pack> m;
        step.measure(scan, of, splat_mask<Pack>(true), m, true);
        const Fix<Pack> fix = position_fix(of.spec, m);
        for (int l = 0; l < lanes && from + l < rows.count; ++l) {
            Fix<double> &one = positions[from + l];
            one.position = lane(fix.position, l), one.velocity = lane(fix.velocity, l);
            for (int a = 0; a < 3; ++a) one.p[a] = fix.p[a][l], one.v[a] = fix.v[a][l];
            for (int k = 0; k < 6; ++k) one.P[k] = fix.P[k][l], one.V[k] = fix.V[k][l];
            for (int a = 0; a < of.spec.axes; ++a) {
                one.position = one.position && std::isfinite(one.p[a]);
                one.velocity = one.velocity && std::isfinite(one.v[a]);
            }
        }
    }
    report.unusable = plots.take(rows, positions);
    report.plots = plots.count;
}

void Many::predict(double t, int sensor) {
    const int packs = int(pool.packs.size());
    candidates.resize(pool.slots()), shares.resize(pool.slots());
    crowded.assign(packs, 0);
    const SensorView &view = sensors[sensor];
    Gate gate{rules.gate};
    if (view.scanning) gate.log_odds = std::log(view.detection / (1.0 - view.detection)) - std::log(view.clutter + view.detection * view.undetected);
    over_packs([&](Scanner &scanner, int p) {
        bool live[lanes], sure[lanes], some = false;
        for (int l = 0; l < lanes; ++l) {
            some = (live[l] = pool.live(p * lanes + l)) || some;
            sure[l] = view.scanning && pool.life[p * lanes + l].existence > rules.established;
        }
        TrackPack &pack = pool.packs[p];
        const bool instant = plots.time.empty() || !some;
        scanner.predict(pack, instant ? larger<Pack>(splat<Pack>(t), pack.state.time) : scanner.expected(pack, plots, t, gate, live, sure));
        if (some) crowded[p] = scanner.look(pack, plots, sensor, gate, rules.most_plots, live, sure, &candidates[p * lanes]);
    });
}

// Predicted velocity of a track and its covariance, as the mean over its modes.
Speed Many::speed_of(int s) const {
    const int l = s % lanes;
    const TrackPack &pack = pool.packs[s / lanes];
    Speed at{0.0, 0.0, 0.0, 0.0, 0.0};
    for (int j = 0; j < c->count; ++j) {
        const Mode<Pack> &mode = c->modes[j];
        const Pack *x = &pack.predicted[mode.place], *P = x + mode.shape.n;
        const double w = pack.prior[j][l];
        const int u = 1, v = mode.shape.axes > 1 ? mode.shape.block + 1 : 1;
        at.x += w * x[u][l], at.y += w * x[v][l];
        at.xx += w * P[packed(u, u)][l], at.xy += u == v ? 0.0 : w * P[packed(v, u)][l], at.yy += w * P[packed(v, v)][l];
    }
    return at;
}

// The edges' weights: log(Pd l / (clutter + Pd undetected)), and what codes say.
void Many::weigh(int sensor) {
    constexpr double told = 6.9;  // a thousand times likelier, or less so
    const SensorView &view = sensors[sensor];
    const double log_ground = std::log(view.clutter + view.detection * view.undetected);
    const double log_detection = std::log(view.detection);
    Weighing &w = weighing;
    w.ratio.clear(plots.count);
    w.distance2.clear();
    parents.assign(plots.count, Parent());
    w.speed.resize(std::isfinite(rules.abreast) ? pool.slots() : 0);
    w.existence.resize(pool.slots()), w.detection.resize(pool.slots()), w.unseen.resize(pool.slots());
    for (int s = 0; s < pool.slots(); ++s) {
        if (pool.live(s)) {
            Life &one = pool.life[s];
            const TrackPack &pack = pool.packs[s / lanes];
            const Mode<Pack> &mode = c->modes[0];
            const Pack *x = &pack.predicted[mode.place];
            const double east = x[0][s % lanes], north = x[mode.shape.axes < 2 ? 0 : mode.shape.block][s % lanes];
            const bool served = !sector.whole() && pool.now - one.served < 0.5 * sector.period;
            one.due = !served && sector.holds(east - view.site[0], north - view.site[1]);
            const bool seen = one.due && (mode.shape.axes < 2 || view.sees(east, north));
            if (!w.speed.empty() && one.existence > rules.established) w.speed[s] = speed_of(s);
            // Not twice within half a turn, where it crosses from one sector into another.
            if (served) candidates[s].clear();
            w.existence[s] = std::min(one.existence, 1.0 - 1e-12);
            w.unseen[s] = seen && view.scanning ? 1.0 - view.detection : 1.0;
            for (const Candidate &each : candidates[s]) {
                double value = log_detection + each.log_likelihood - log_ground - plots.log_unit[each.plot];
                const std::int64_t code = plots.code[each.plot];
                if (code >= 0 && one.code >= 0) value += code == one.code ? told : -told;
                if (one.confirmed && value > parents[each.plot].gain) parents[each.plot] = {one.id, one.score, value};
                w.ratio.plot.push_back(each.plot), w.ratio.value.push_back(value), w.distance2.push_back(each.distance2);
            }
        }
        w.ratio.begin.push_back(int(w.ratio.plot.size()));
    }
}

// log of how much likelier the scan is if the track is there than if it is not, of these chances: without a plot, and with one.
double Many::evidence(int s, double unseen, double hit) const {
    const double r = std::max(weighing.existence[s], 1e-300), gone = 1.0 - r + r * weighing.unseen[s];
    return std::log(std::max(unseen + hit * gone / (r * std::max(decide.found.miss[s], 1e-300)), 1e-300));
}

// What a track takes in, and how probable it is then that it exists.
void Many::share_out(int s) {
    const Weighing &w = weighing;
    Life &one = pool.life[s];
    std::vector<Share> &take = shares[s];
    take.clear();
    const double r = w.existence[s], unseen = w.unseen[s];
    const bool hard = rules.association == Association::gnn || rules.association == Association::nearest;
    double hit = 0.0, likeliest = 0.0;
    int best = -1;
    for (int e = w.ratio.begin[s]; e < w.ratio.begin[s + 1]; ++e) {
        const double p = decide.found.hit[e];
        hit += p;
        if (p > likeliest) likeliest = p, best = e;
        take.push_back({w.ratio.plot[e], p});
    }
    const double miss = decide.found.miss[s] * r * unseen / (1.0 - r + r * unseen);
    double after = hit + miss;
    // A plot that is taken for granted says of existence what its likelihood ratio says.
    if (hard && best >= 0) {
        const double gain = r * std::exp(std::min(w.ratio.value[best], 600.0));
        after = gain / (gain + 1.0 - r);
    }
    for (Share &each : take) each.weight /= hit + miss;
    std::erase_if(take, [](const Share &each) { return !(each.weight > 1e-10); });
    one.existence = std::min(after, 1.0);
    one.plot = best < 0 ? -1 : w.ratio.plot[best];
    one.share = hit;
    if (scored(one) && !idle(s)) one.score += hard && best >= 0 ? w.ratio.value[best] : evidence(s, unseen, hit);
}

// Is a track neither due in this sector nor more probably than not seen in it? Then the sector leaves it as it is: it keeps its time,
// so that its own plot never lies in its past.
bool Many::idle(int s) const {
    const Life &one = pool.life[s];
    return !sector.whole() && pool.live(s) && !one.due && !(one.share > 0.5);
}

// Does this scan say whether the sensor has seen the track? With sectors a plot may be taken one sector early, and then the track is not
// due in its own: it counts here, or only misses would be counted there.
bool Many::looked_at(int s, int sensor) const {
    const bool early = !sector.whole() && sensors[sensor].scanning && !pool.life[s].due && pool.life[s].share > 0.5;
    return weighing.unseen[s] < 1.0 || early;
}

void Many::leave(const std::vector<int> &idle) {
    for (int s : idle) {
        copy_lane(before[s / lanes], s % lanes, pool.packs[s / lanes].state, s % lanes);
        pool.life[s].existence = weighing.existence[s];
    }
}

// A track of one plot is one target per plot near it, not the mean of them: each becomes a track of its own.
void Many::split(int sensor) {
    const Weighing &w = weighing;
    std::vector<int> single;  // found first, since twins take free slots
    for (int s = 0; s < pool.slots(); ++s)
        if (pool.live(s) && pool.life[s].plots == 1 && !idle(s)) single.push_back(s);
    const double least = rules.drop * sensors[sensor].birth();
    std::vector<std::pair<double, int>> branches;
    std::vector<int> ended;
    for (int s : single) {
        branches.clear();
        for (int e = w.ratio.begin[s]; e < w.ratio.begin[s + 1]; ++e)
            if (w.distance2[e] < rules.split_gate && decide.found.hit[e] > least) branches.push_back({-decide.found.hit[e], e});
        const double r = w.existence[s], miss = decide.found.miss[s] * r * w.unseen[s] / (1.0 - r + r * w.unseen[s]);
        // Nobody looked, or it probably is there all the same: it waits for its second plot.
        const bool waits = miss >= rules.patience || w.unseen[s] == 1.0;
        if (branches.empty()) {
            if (!waits) ended.push_back(s);
            continue;
        }
        std::sort(branches.begin(), branches.end());
        // Each branch has its own plot to speak for it, not all of them.
        const bool counts = scored(pool.life[s]);
        const double before = counts ? pool.life[s].score - evidence(s, w.unseen[s], 1.0 - decide.found.miss[s]) : 0.0;
        const auto becomes = [&](int slot, int e) {
            Life &one = pool.life[slot];
            one.existence = e < 0 ? miss : decide.found.hit[e];
            if (counts) one.score = before + (e < 0 ? evidence(s, w.unseen[s], 0.0) : evidence(s, 0.0, decide.found.hit[e]));
            one.plot = e < 0 ? -1 : w.ratio.plot[e], one.share = e < 0 ? 0.0 : 1.0;
            shares[slot].clear();
            if (e >= 0) shares[slot].push_back({w.ratio.plot[e], 1.0});
        };
        const bool missed_first = waits && miss > decide.found.hit[branches[0].second];
        for (std::size_t k = missed_first ? 0 : 1; k < branches.size() + (waits && !missed_first); ++k) {
            if (pool.living() >= rules.most_tracks) break;
            const int other = pool.twin(s);
            candidates.resize(pool.slots()), shares.resize(pool.slots());
            candidates[other].clear();
            pool.life[other].id = next_id++;
            becomes(other, k < branches.size() ? branches[k].second : -1);
        }
        becomes(s, missed_first ? -1 : branches[0].second);
    }
    for (int s : ended) pool.give_back(s);
    dropped = int(ended.size());
}

// Every plot that nobody claims may be a target's that was not seen before.
void Many::bear(double t, int sensor, ScanReport &report) {
    const SensorView &view = sensors[sensor];
    const double birth = view.birth(), least = std::max(rules.drop * birth, 1e-15);
    std::vector<std::pair<int, int>> born;  // slot, plot
    for (int j = 0; j < plots.count; ++j) {
        const double r = decide.found.lone[j] * birth;
        if (plots.waiting[j]) continue;
        if (!(r > least) || !(decide.found.lone[j] > rules.unclaimed)) continue;
        if (pool.living() >= rules.most_tracks) {
            report.full = true;
            break;
        }
        const int slot = pool.take();
        Life &one = pool.life[slot];
        one.id = next_id++, one.code = plots.code[j];
        one.existence = one.birth = r, one.begun = one.seen = t;
        one.plots = 1, one.plot = j, one.share = 1.0;
        one.served = one.hit = t;
        if (const Parent &of = parents[j]; of.id >= 0) one.parent = of.id, one.parting = of.score, one.score = of.score + of.gain;
        pool.packs[slot / lanes].state.time[slot % lanes] = plots.time.empty() ? t : plots.time[j];
        born.push_back({slot, j});
    }
    std::sort(born.begin(), born.end());
    report.born = int(born.size());
    for (std::size_t k = 0; k < born.size();) {
        const int p = born[k].first / lanes;
        int plot_of[lanes];
        std::fill(plot_of, plot_of + lanes, -1);
        for (; k < born.size() && born[k].first / lanes == p; ++k) plot_of[born[k].first % lanes] = born[k].second;
        scanners[0]->begin(pool.packs[p], plots, plot_of);
    }
}

// Is a track where no sensor looks?
bool Many::outside(int s) const {
    const Mode<Pack> &mode = c->modes[0];
    if (mode.shape.axes < 2) return false;
    const TrackState<Pack> &state = pool.packs[s / lanes].state;
    double x = 0.0, y = 0.0;
    for (int j = 0; j < c->count; ++j) {
        const Mode<Pack> &each = c->modes[j];
        x += state.probability[j][s % lanes] * state.arena[each.place][s % lanes];
        y += state.probability[j][s % lanes] * state.arena[each.place + each.shape.block][s % lanes];
    }
    return std::none_of(sensors.begin(), sensors.end(), [&](const SensorView &view) { return view.sees(x, y); });
}

// Confirm, and drop what no longer is there.
void Many::judge(double t, int sensor, ScanReport &report) {
    const double least = 1e-15;
    const bool looked = sensors[sensor].scanning;
    std::vector<int> heirs;
    for (int s = 0; s < pool.slots(); ++s) {
        if (!pool.live(s)) continue;
        Life &one = pool.life[s];
        if (one.age < 0) {
            one.age = 0;
        } else {
            one.age += looked && (one.due || one.share > 0.5);
            if (one.due) one.served = t;
            if (one.share > 0.5) {
                ++one.plots, one.seen = t;
                one.served = one.hit = t;
                if (one.plot >= 0 && plots.code[one.plot] >= 0) one.code = plots.code[one.plot];
            }
            const bool lost = one.existence < 0.5 && one.age > rules.young && int(candidates[s].size()) > rules.crowd;
            if (one.existence < std::max(least, rules.drop * one.birth) || t - one.seen > rules.drop_after || lost) {
                pool.give_back(s);
                ++report.dropped;
                continue;
            }
        }
        one.outside = outside(s);
        one.confirmed = !one.outside && one.existence > (one.confirmed ? rules.keep : rules.confirm);
        report.confirmed += one.confirmed;
        if (one.confirmed && one.parent >= 0) heirs.push_back(s);
        if (one.plot >= 0) one.plot = plots.row[one.plot];
    }
    if (!heirs.empty()) inherit(heirs, report);
    if (looked && sector.last && rules.merge_after > 0) merge(report);
    pool.shrink();
    report.living = pool.living();
}

// The clutter is what is no track's and no new target's.
void Many::learn(double, int sensor) {
    SensorView &view = sensors[sensor];
    double sum = 0.0;
    for (int j = 0; j < plots.count; ++j)
        if (!plots.waiting[j] && view.sees(plots.fix[j].p[0], plots.fix[j].p[1])) sum += decide.found.lone[j];
    const double share = view.clutter / (view.clutter + view.detection * view.undetected);
    if (view.learning) {
        const double rate = sector.part * std::max(0.05, 1.0 / (2.0 + view.scans)), area = sector.part * view.area;
        // A burst counts as four times the usual, so that it is soon forgotten.
        const double seen = std::min(sum * share, 4.0 * view.clutter * area + 10.0);
        view.clutter = std::max((1.0 - rate) * view.clutter + rate * seen / area, 1e-3 / view.area);
    }
    view.scans += sector.last;
    if (view.scanning && sector.last) view.undetected *= 1.0 - view.detection;
    if (!sector.whole() && sector.last) {
        const double survival = std::exp(-sector.period / rules.life);
        view.undetected = survival * view.undetected + view.arrivals * sector.period;
    }
}

// log p(plots | earlier ones): false plots and targets not seen before are Poisson, tracks are Bernoulli.
//     -(lambda + Pd u) area + sum_j log(lambda + Pd u) + sum_i log(1 - r_i Pd) + log(sum over assignments of prod psi)
double Many::log_likelihood(int sensor) const {
    const SensorView &view = sensors[sensor];
    const double ground = view.clutter + view.detection * view.undetected;
    double sum = decide.log_total - ground * view.area;
    for (int j = 0; j < plots.count; ++j) sum += std::log(ground) + plots.log_unit[j];
    for (int s = 0; s < pool.slots(); ++s)
        if (pool.live(s)) sum += std::log(1.0 - weighing.existence[s] + weighing.existence[s] * weighing.unseen[s]);
    return sum;
}

std::vector<Share> Many::taken(int slot) const {
    const Life &one = pool.life[slot];
    // A track that begins has its plot for sure; its row is known already.
    if (one.age == 0 && one.plot >= 0) return {{one.plot, 1.0}};
    std::vector<Share> found;
    for (const Share &each : shares[slot]) found.push_back({plots.row[each.plot], each.weight});
    return found;
}

ScanReport Many::scan(double t, int sensor, const PlotRows &rows, const Sector &part) {
    ScanReport report;
    sector = part;
    const double dt = std::isnan(time) ? 0.0 : t - time;
    pool.now = t;
    measure(rows, sensor, report);
    const double survival = std::exp(-dt / rules.life);
    for (Life &one : pool.life) one.existence *= one.outside ? survival * std::exp(-dt / rules.leave) : survival;
    // With sectors each place is looked at once in a turn: what came in since then is added turn by turn, see learn.
    for (std::size_t k = 0; k < sensors.size(); ++k)
        if (sector.whole() || int(k) != sensor) sensors[k].undetected = survival * sensors[k].undetected + sensors[k].arrivals * dt;
    before.clear();
    if (!sector.whole())
        for (const TrackPack &pack : pool.packs) before.push_back(pack.state);
    predict(t, sensor);
    for (char each : crowded) report.crowded = report.crowded || each;
    weigh(sensor);
    decide.established = rules.established, decide.left = rules.left, decide.abreast = rules.abreast, decide.weigh_all = rules.likelihood;
    decide(rules.association, weighing);
    if (rules.likelihood && sector.whole()) report.log_likelihood = log_likelihood(sensor);
    report.inexact = decide.inexact;
    for (int s = 0; s < pool.slots(); ++s)
        if (pool.live(s)) {
            share_out(s);
            const Life &one = pool.life[s];
            const bool counts = looked_at(s, sensor) && weighing.existence[s] > rules.sure && one.plots >= 5;
            report.sure += counts, report.seen += counts && one.share > 0.5;
        } else {
            shares[s].clear();
        }
    std::vector<int> idlers;  // found first, since twins of others take free slots
    for (int s = 0; s < pool.slots() && !sector.whole(); ++s)
        if (idle(s)) idlers.push_back(s), shares[s].clear();
    const bool soft = rules.association != Association::gnn && rules.association != Association::nearest;
    dropped = 0;
    if (rules.split && soft) split(sensor);
    for (std::size_t s = 0; s < shares.size(); ++s)
        if (!pool.live(int(s))) shares[s].clear();
    report.dropped = dropped;
    over_packs([&](Scanner &scanner, int p) {
        const auto live = [](const Life &one) { return one.id >= 0; };
        const auto from = pool.life.begin() + p * lanes;
        if (std::any_of(from, from + lanes, live)) scanner.take_in(pool.packs[p], plots, sensor, &shares[p * lanes]);
    });
    leave(idlers);
    bear(t, sensor, report);
    lone.assign(rows.count, NAN);
    for (int j = 0; j < plots.count; ++j) lone[plots.row[j]] = decide.found.lone[j];
    candidates.resize(pool.slots()), shares.resize(pool.slots());
    judge(t, sensor, report);
    learn(dt, sensor);
    candidates.resize(pool.slots()), shares.resize(pool.slots());
    time = t;
    return report;
}

}  // namespace jink::inline JINK_LEVEL
