// One scan of one track (or one pack of tracks): mix, predict, update, weigh. What combine.hpp makes of it goes out.
#pragma once

#include "scan/consistency.hpp"
#include "scan/hindsight.hpp"
#include "scan/input_estimation.hpp"
#include "scan/propagate.hpp"
#include "scan/scores.hpp"
#include "scan/start.hpp"
#include "scan/surprise.hpp"
#include "scan/variable_dimension.hpp"

namespace jink::inline JINK_LEVEL {

// What the update sees of a sensor: of a converted one, a position.
template <class T> SensorSpec seen(const Sensor<T> &sensor) {
    SensorSpec spec = sensor.spec;
    if (sensor.converted) spec.kind = SensorKind::position, spec.rows = spec.axes;
    return spec;
}

template <class T> class Step {
  public:
    explicit Step(const Composition<T> &composition);

    const Composition<T> &c;
    Propagate<T> ahead;  // the modes as predicted for this scan

    Outcome<T> step(TrackState<T> &s, const Scan<T> &scan, int detail);

    // The measurement as the sensor's update wants it; a converted one becomes a position with a full covariance.
    void measure(const Scan<T> &scan, const Sensor<T> &sensor, Mask<T> lanes_of_it, Measurement<T> &m, bool as_it_is = false) const {
        const SensorSpec &spec = sensor.spec;
        const Mask<T> usable = scan.active & lanes_of_it;
        for (int r = 0; r < spec.rows; ++r) m.z[r] = scan.z[r], m.present[r] = usable & inverse(is_nan(scan.z[r]));
        m.full = scan.own_noise ? scan.own_full : spec.correlated;
        const T *noise = scan.own_noise ? scan.R : sensor.noise.data();
        const int terms = m.full ? packed_size(spec.rows) : spec.rows;
        for (int k = 0; k < terms; ++k) m.R[k] = noise[k];
        if (!sensor.converted || as_it_is) return;
        const Fix<T> fix = position_fix(spec, m);
        for (int a = 0; a < spec.axes; ++a) m.z[a] = fix.p[a], m.present[a] = fix.position;
        for (int k = 0; k < packed_size(spec.axes); ++k) m.R[k] = fix.P[k];
        m.full = true;
    }

    // The measured position, whatever the sensors.
    Fix<T> position_of(const Scan<T> &scan) const {
        Fix<T> fix;
        for (int sensor = 0; sensor < int(c.sensors.size()); ++sensor) {
            Mask<T> mine = splat_mask<T>(!scan.sensor);
            for (int l = 0; l < width<T> && scan.sensor; ++l) set_lane(mine, l, scan.sensor[l] == sensor);
            if (!scan.sensor && sensor != scan.one_sensor) continue;
            Measurement<T> m;
            measure(scan, c.sensors[sensor], mine, m, true);
            Fix<T> own = position_fix(c.sensors[sensor].spec, m);
            own.position = own.position & scan.active & mine;
            if (!scan.sensor) return own;
            if (sensor == 0) fix = own;
            fix.position = fix.position | own.position;
            for (int a = 0; a < 3; ++a) fix.p[a] = select<T>(own.position, own.p[a], fix.p[a]);
            for (int k = 0; k < 6; ++k) fix.P[k] = select<T>(own.position, own.P[k], fix.P[k]);
        }
        return fix;
    }

  private:
    InputEstimation<T> estimation;
    VariableDimension<T> dimension;
    Scores<T> scores;
    Hindsight<T> hindsight;
    std::vector<T> log_prior, posterior, updated;  // updated: pairs
    TrackState<T> before;                          // the scan, where some mode adapts to residuals
    std::vector<Innovation<T>> innovations;       // of each mode or pair of modes, then of the side estimator
    BestFit<T> best;
    int always = plain;

    Hypotheses<T> hypotheses() const {
        if (ahead.pairwise()) return {c.count * c.count, ahead.pair_prior.data(), innovations.data()};
        return {c.count, ahead.prior.data(), innovations.data()};
    }

    // A slot that no lane has a mode in: nothing was predicted for it, and what lies there is of other tracks.
    bool unused(const TrackState<T> &s, int j) const { return c.proposes() && j < c.count && !any(living(s.next[j])); }

    // What is seen of a mode that there is not.
    static Innovation<T> nothing() {
        Innovation<T> v{};
        v.det = splat<T>(1.0);
        for (auto &S : v.S) S = splat<T>(1.0);
        return v;
    }

    void update_modes(TrackState<T> &s, const Sensor<T> &sensor, const Measurement<T> &m, int detail) {
        update_bank(s, ahead, innovations, sensor, m, detail);
    }

    void update_bank(TrackState<T> &s, const Propagate<T> &from, std::vector<Innovation<T>> &found, const Sensor<T> &sensor, const Measurement<T> &m, int detail) {
        const SensorSpec spec = seen(sensor);
        for (int j = 0; j < int(c.modes.size()); ++j) {
            const Mode<T> &mode = c.modes[j];
            if (unused(s, j)) {
                found[j] = nothing();
                continue;
            }
            const UpdateKernels<T> &k = mode.update;
            UpdateKernel<T> kernel = k.general;
            if (spec.linear()) kernel = spec.kind == SensorKind::position ? k.position : k.position_velocity;
            else if (!spec.linear() && c.declared.unscented) kernel = k.unscented;
            if (from.pairwise() && j < c.count) {
                for (int i = 0; i < c.count; ++i) {
                    const int at = (j * c.count + i) * from.stride;
                    kernel(spec, m, &from.pairs[at], &updated[at], found[j * c.count + i], detail != plain);
                }
                continue;
            }
            Innovation<T> &v = j < c.count ? found[j] : found.back();
            kernel(spec, m, &from.predicted[mode.place], &s.arena[mode.place], v, detail != plain);
        }
    }

    // Lanes with different sensors: each sensor's lanes are stepped as if they were alone, the others kept.
    void several(TrackState<T> &s, const Scan<T> &scan, int detail, Outcome<T> &out) {
        const TrackState<T> held = s;
        TrackState<T> after = s;
        for (int sensor = 0; sensor < int(c.sensors.size()); ++sensor) {
            Mask<T> mine = splat_mask<T>(false);
            for (int l = 0; l < width<T>; ++l) set_lane(mine, l, scan.sensor[l] == sensor);
            if (!any(mine)) continue;
            TrackState<T> trial = held;
            Outcome<T> part;
            Measurement<T> m;
            measure(scan, c.sensors[sensor], mine, m);
            update_modes(trial, c.sensors[sensor], m, detail);
            finish(trial, scan, c.sensors[sensor], m, mine, detail, part);
            merge(mine, trial, part, after, out);
        }
        s = after;
        s.settled = all(s.running);
    }

    void merge(Mask<T> mine, const TrackState<T> &from, const Outcome<T> &part, TrackState<T> &to, Outcome<T> &out) const {
        const auto take = [&](T &a, const T &b) { a = select<T>(mine, b, a); };
        const auto take_mask = [&](Mask<T> &a, Mask<T> b) { a = (a & inverse(mine)) | (b & mine); };
        for (int k = 0; k < c.arena_size; ++k) take(to.arena[k], from.arena[k]);
        for (int j = 0; j < c.count; ++j) take(to.probability[j], from.probability[j]);
        for (std::size_t k = 0; k < to.carry.size(); ++k) take(to.carry[k], from.carry[k]);
        for (std::size_t k = 0; k < to.memory.size(); ++k) take(to.memory[k], from.memory[k]);
        for (std::size_t k = 0; k < to.next.size(); ++k) take(to.next[k], from.next[k]), take(to.alive[k], from.alive[k]);
        take(to.last_accepted, from.last_accepted), take(to.last_height, from.last_height), take(to.first_time, from.first_time), take(to.rejections, from.rejections);
        take(to.surprise, from.surprise), take(to.surprise_dof, from.surprise_dof);
        take(to.doubt, from.doubt), take(to.in_doubt, from.in_doubt), take(to.height_in_doubt, from.height_in_doubt);
        for (std::size_t k = 0; k < to.believed.size(); ++k) take(to.believed[k], from.believed[k]), take(to.doubted[k], from.doubted[k]);
        for (int k = 0; k < 3; ++k) take(to.first[k], from.first[k]);
        for (int k = 0; k < 6; ++k) take(to.first_P[k], from.first_P[k]);
        take_mask(to.started, from.started), take_mask(to.running, from.running);
        take(out.log_likelihood, part.log_likelihood), take(out.dof, part.dof), take(out.nis, part.nis);
        for (int r = 0; r < largest_measurement; ++r) take(out.pit[r], part.pit[r]);
        take_mask(out.measured, part.measured), take_mask(out.scored, part.scored), take_mask(out.gated, part.gated);
        take_mask(out.restarted, part.restarted), take_mask(out.initialised, part.initialised);
        take_mask(out.decided, part.decided), take_mask(out.upheld, part.upheld);
    }

    // Bayes' rule over the modes, gating, and the start of tracks that need one; `here`: the lanes whose sensor this is.
    void finish(TrackState<T> &s, const Scan<T> &scan, const Sensor<T> &sensor, const Measurement<T> &m, Mask<T> here, int detail, Outcome<T> &out) {
        const SensorSpec spec = seen(sensor);
        const T zero = splat<T>(0.0);
        T dof = zero, log_outlier = zero;
        for (int r = 0; r < spec.rows; ++r) {
            dof = dof + select<T>(m.present[r], splat<T>(1.0), zero);
            if (c.declared.outlier_share > 0.0)
                log_outlier = log_outlier - select<T>(m.present[r], splat<T>(sensor.log_extent[r]), zero);
        }
        out.dof = dof;
        out.measured = dof > zero;
        out.gated = out.restarted = out.initialised = out.decided = out.upheld = splat_mask<T>(false);
        out.scored = out.measured & s.running;
        if (hindsight.two()) update_bank(hindsight.state, hindsight.ahead, hindsight.innovations, sensor, m, detail);
        const bool over_both = hindsight.two() && (detail & (with_nis | with_pit));
        const Hypotheses<T> all_modes = over_both ? hindsight.joined(hypotheses()) : hypotheses();
        if (detail & with_nis) out.nis = matched_nis(all_modes, spec.rows, m.present);
        if (detail & with_pit) {
            for (auto &value : out.pit) value = nan_of<T>();
            transform(all_modes, spec.rows, m.present, log_prior, out.pit);
        }
        const bool gating = c.declared.outlier_share > 0.0;
        if (gating) ahead.merge_pairs();
        weigh(s, dof, out);
        if (hindsight.two()) settle(s, here, log_outlier, out);
        if (ahead.pairwise()) collapse(s);
        if (scores.active()) scores(s, ahead.prior.data(), innovations.data(), dof);
        Mask<T> impossible = out.measured & s.started & inverse(magnitude(out.log_likelihood) <= splat<T>(unlikeliest));
        const Mask<T> vague = out.measured & s.running & inverse(best.det <= splat<T>(vaguest));
        if (any(vague)) impossible = impossible | (vague & inverse(within_range()));
        if (any(impossible)) disbelieve(s, scan.input, impossible, gating, out);
        if (gating) gate(s, scan.input, sensor, m, log_outlier, out);
        if (!spec.linear()) {
            Mask<T> direction = out.measured & s.running;
            if (spec.kind == SensorKind::polar) direction = direction & inverse(m.present[0]);
            if (any(direction)) bring_back(s, direction);
        }
        if (estimation.active()) estimation(s, ahead, spec, m, innovations[0], out.measured & inverse(out.gated) & s.running);
        const Mask<T> height = spec.axes == 3 ? m.present[std::min(2, spec.rows - 1)] : splat_mask<T>(false);
        if (hindsight.active()) hindsight.date(s, out, height);
        s.last_accepted = select<T>(out.measured & inverse(out.gated), s.time, s.last_accepted);
        if (spec.axes == 3) s.last_height = select<T>(height & inverse(out.gated), s.time, s.last_height);
        if (!s.settled || any(out.restarted)) begin(s, sensor.spec, scan, sensor, out);
    }

    void weigh(TrackState<T> &s, T dof, Outcome<T> &out) {
        out.log_likelihood = weigh_modes(s, hypotheses(), innovations, ahead.pairwise() ? posterior.data() : s.probability.data(), dof, best);
        out.log_likelihood = select<T>(out.measured, out.log_likelihood, splat<T>(0.0));
    }

    // Of the modes given what was measured, in `after`; returns the log-likelihood of the measurement over all of them.
    T weigh_modes(const TrackState<T> &s, const Hypotheses<T> &h, std::vector<Innovation<T>> &found, T *after, T dof, BestFit<T> &fit) {
        constexpr double log_two_pi = 1.83787706640934548356;
        const int n = h.count;
        fit = {found[0].nis, found[0].det};
        if (n == 1) return -0.5 * (found[0].nis + logarithm<T>(found[0].det) + log_two_pi * dof);
        for (int j = 0; (c.proposes() || ahead.pairwise()) && j < n; ++j) {  // what cannot be does not say which fits best
            const Mask<T> possible = h.prior[j] > splat<T>(0.0);
            found[j].nis = select<T>(c.proposes() ? possible & living(s.next[j]) : possible, found[j].nis, splat<T>(1e300));
        }
        // c_j N_j / max over exp(-nis/2) of the best fitting mode, which cannot all underflow
        fit = {found[0].nis, found[0].det};
        for (int j = 1; j < n; ++j) {
            fit.det = select<T>(found[j].nis < fit.nis, found[j].det, fit.det);
            fit.nis = smaller<T>(found[j].nis, fit.nis);
        }
        const T least = fit.nis;
        T sum = splat<T>(0.0);
        for (int j = 0; j < n; ++j) {
            after[j] = h.prior[j] * reciprocal_root(found[j].det) * exponential<T>(0.5 * (least - found[j].nis));
            sum = sum + after[j];
        }
        const T over = reciprocal(sum);
        for (int j = 0; j < n; ++j) after[j] = larger<T>(after[j] * over, smaller<T>(h.prior[j], splat<T>(1e-100)));  // see weigh_sources
        return logarithm<T>(sum) - 0.5 * (least + log_two_pi * dof);
    }

    // Two banks of modes follow a measurement that was in doubt: this one decides.
    void settle(TrackState<T> &s, Mask<T> here, T log_outlier, Outcome<T> &out) {
        const Hypotheses<T> h{c.count, hindsight.ahead.prior.data(), hindsight.innovations.data()};
        BestFit<T> fit;
        const T other = weigh_modes(hindsight.state, h, hindsight.innovations, hindsight.state.probability.data(), out.dof, fit);
        hindsight.settle(s, ahead, here, other, log_outlier, out);
        const Mask<T> closer = out.decided & (fit.nis < best.nis);
        best.det = select<T>(closer, fit.det, best.det), best.nis = select<T>(closer, fit.nis, best.nis);
    }

    // GPB2: each mode's pairs become one estimate.
    void collapse(TrackState<T> &s) {
        const int m = c.count;
        for (int j = 0; j < m; ++j) {
            T *p = &posterior[j * m], sum = p[0];
            for (int i = 1; i < m; ++i) sum = sum + p[i];
            s.probability[j] = sum;
            const T over = reciprocal(larger<T>(sum, splat<T>(1e-300)));
            const Mask<T> dead = sum < splat<T>(1e-300);
            for (int i = 0; i < m; ++i) p[i] = select<T>(dead, splat<T>(1.0 / m), p[i] * over);
            ahead.merge(j, &updated[j * m * ahead.stride], &s.arena[c.modes[j].place], p);
        }
    }

    // A measurement is either the target's, with the innovation's density over all modes, or an outlier, uniform over the
    // sensor's extent. The likelihood is that of the mixture; at run time the likelier of the two is believed.
    void gate(TrackState<T> &s, const T *input, const Sensor<T> &sensor, const Measurement<T> &m, T log_outlier, Outcome<T> &out) {
        const T target = out.log_likelihood + c.log_target_share, outlier = log_outlier + c.log_outlier_share;
        const T high = larger<T>(target, outlier), low = smaller<T>(target, outlier);
        const T mixture = high + logarithm<T>(1.0 + exponential<T>(low - high));
        out.log_likelihood = select<T>(out.measured, mixture, out.log_likelihood);
        out.gated = out.gated | (out.measured & (target < outlier) & s.running);
        const BestFit<T> fit = best;
        Mask<T> questioned = out.gated, explained = splat_mask<T>(false);
        if (hindsight.active()) questioned = questioned | (out.measured & s.running & hindsight.doubts(target, outlier));
        if (any(questioned) && !scores.active()) {
            explained = questioned & (fit.nis <= splat<T>(unlikeliest)) & Surprise::explains<T>(s, fit, out.dof, c.log_target_share, outlier);
            const Mask<T> widened = explained & out.gated;
            if (any(widened)) believe(s, sensor, m, select<T>(widened, Surprise::scale_with<T>(s, fit, out.dof), splat<T>(1.0)), out);
            out.gated = out.gated & inverse(explained);
        }
        Surprise::add<T>(s, fit, out.dof, out.measured & s.running & inverse(out.gated));
        s.rejections = select<T>(out.measured & s.running, select<T>(out.gated, s.rejections + 1.0, splat<T>(0.0)), s.rejections);
        if (c.declared.restart_after > 0)
            out.restarted = out.restarted | (out.gated & s.running & (s.rejections >= splat<T>(c.declared.restart_after)));
        Mask<T> doubtful = splat_mask<T>(false);
        if (hindsight.active()) doubtful = hindsight.begin(s, ahead, out.measured & s.running & inverse(explained | out.restarted), target, outlier);
        if (any(out.gated)) keep_prediction(s, input, out.gated);
        if (any(doubtful)) hindsight.blend(s, doubtful, out.gated);
    }

    void keep_prediction(TrackState<T> &s, const T *input, Mask<T> which) {
        if (c.residuals && c.declared.outlier_share > 0.0) {
            TrackState<T> same = before;
            ahead.again_without_fix(same, input, which);
            for (std::size_t k = 0; k < s.carry.size(); ++k) s.carry[k] = select<T>(which, same.carry[k], s.carry[k]);
        }
        for (int j = 0; j < int(c.modes.size()); ++j) {
            if (unused(s, j)) continue;
            const Mode<T> &mode = c.modes[j];
            for (int k = mode.place; k < mode.place + mode.size(); ++k)
                s.arena[k] = select<T>(which, ahead.predicted[k], s.arena[k]);
        }
        for (int j = 0; j < c.count; ++j) s.probability[j] = select<T>(which, ahead.prior[j], s.probability[j]);
    }

    // Of what is believed, a log-likelihood: 1e25 standard deviations off. Squares of what such a row leaves are still numbers.
    static constexpr double unlikeliest = 1e50;
    // The determinant of an innovation's covariance above which a track is looked at: it may have gone beyond all range.
    static constexpr double vaguest = 1e100;
    // The farthest and fastest that a track can be, whatever its unit of length.
    static constexpr double strayed = 1e20;

    // A measurement so far off that its likelihood is beyond the range of numbers says nothing of the modes: it is gated, with
    // or without a share of outliers, also while a track waits for its second position. A track that has itself gone beyond all
    // range starts again.
    void disbelieve(TrackState<T> &s, const T *input, Mask<T> which, bool gating, Outcome<T> &out) {
        out.gated = which;
        out.log_likelihood = select<T>(which, splat<T>(-1e300), out.log_likelihood);
        out.nis = select<T>(which & is_nan(out.nis), splat<T>(1e300), out.nis);
        out.restarted = which & s.running & inverse(within_range());
        if (gating) return;
        ahead.merge_pairs();
        keep_prediction(s, input, which);
    }

    // Where every mode's prediction is no farther and no less certain than a track can be. A comparison with NaN is false.
    Mask<T> within_range() const {
        Mask<T> near = splat_mask<T>(true);
        for (int j = 0; j < c.count; ++j) {
            const Mode<T> &mode = c.modes[j];
            const T *x = &ahead.predicted[mode.place], *P = x + mode.shape.n;
            Mask<T> here = splat_mask<T>(true);
            for (int i = 0; i < mode.shape.n; ++i)
                here = here & (magnitude(x[i]) <= splat<T>(strayed)) & (P[packed(i, i)] <= splat<T>(strayed * strayed));
            near = near & (here | inverse(ahead.prior[j] > splat<T>(0.0)));
        }
        return near;
    }

    // Where directions alone are measured nothing holds the range. A track that has strayed comes nearer along its line of sight,
    // with its velocity and its uncertainty: what is measured of it stays the same.
    [[gnu::noinline]] void bring_back(TrackState<T> &s, Mask<T> which) const {
        for (int j = 0; j < int(c.modes.size()); ++j) {
            const StateShape &shape = c.modes[j].shape;
            T *x = &s.arena[c.modes[j].place], reach = magnitude(x[0]);
            for (int a = 1; a < shape.axes; ++a) reach = larger<T>(reach, magnitude(x[a * shape.block]));
            const Mask<T> far = which & (reach > splat<T>(strayed)) & (s.doubt <= splat<T>(0.0));
            if (!any(far)) continue;
            const T nearer = select<T>(far, splat<T>(1e-3 * strayed) / reach, splat<T>(1.0));
            const int scaled = shape.axes * shape.block;  // not a turn rate
            for (int i = 0; i < shape.n; ++i)
                for (int k = 0; k <= i; ++k) {
                    T &covariance = x[shape.n + packed(i, k)];
                    covariance = covariance * (i < scaled ? nearer : splat<T>(1.0)) * (k < scaled ? nearer : splat<T>(1.0));
                }
            for (int i = 0; i < scaled; ++i) x[i] = x[i] * nearer;
        }
    }

    // Updates again, from predictions widened per lane. A lane's result is the same as before where the factor is 1.
    void believe(TrackState<T> &s, const Sensor<T> &sensor, const Measurement<T> &m, T factor, const Outcome<T> &out) {
        const bool merged = hindsight.two();  // other lanes may hold what two banks became
        if (merged) before = s;
        ahead.widen(factor);
        update_modes(s, sensor, m, plain);
        Outcome<T> again = out;
        weigh(s, out.dof, again);
        if (ahead.pairwise()) collapse(s);
        if (!merged) return;
        const Mask<T> same = factor == splat<T>(1.0);
        for (int k = 0; k < c.arena_size; ++k) s.arena[k] = select<T>(same, before.arena[k], s.arena[k]);
        for (int j = 0; j < c.count; ++j) s.probability[j] = select<T>(same, before.probability[j], s.probability[j]);
    }

    // Tracks without a state start from one measured position; the second position completes a two-point start.
    void begin(TrackState<T> &s, const SensorSpec &spec, const Scan<T> &scan, const Sensor<T> &sensor, Outcome<T> &out) {
        Measurement<T> m;
        measure(scan, sensor, splat_mask<T>(true), m, true);
        const Fix<T> fix = position_fix(spec, m);
        Mask<T> fresh = scan.active & fix.position & (inverse(s.started) | out.restarted);
        Mask<T> second = scan.active & fix.position & s.started & inverse(s.running) & inverse(out.restarted);
        const bool two_point = c.declared.start != Start::one_point;
        Mask<T> given_up = splat_mask<T>(false);  // the first position, because of the second
        if (any(second) && c.declared.start == Start::bounded_two_point) given_up = contradicted(c, s, fix, second);
        const T tries = s.rejections + 1.0;
        fresh = fresh | given_up, second = second & inverse(given_up);
        if (any(second)) complete(c, s, fix, second);
        if (any(fresh)) {
            start(c, s, fix, fresh);
            const Mask<T> done = two_point ? fix.velocity | out.restarted : splat_mask<T>(true);
            s.running = (s.running & inverse(fresh)) | (fresh & done);
        }
        out.initialised = fresh | (second & s.running);
        out.restarted = out.restarted & fresh;
        out.gated = out.gated & inverse(out.initialised & inverse(out.restarted));
        const Mask<T> counted = out.scored | out.restarted;
        out.log_likelihood = select<T>(counted, out.log_likelihood, splat<T>(0.0));
        out.scored = out.scored & inverse(fresh);
        s.started = s.started | fresh;
        for (T *count : {&s.rejections, &s.surprise, &s.surprise_dof, &s.doubt}) *count = select<T>(fresh | (second & s.running), splat<T>(0.0), *count);
        s.rejections = select<T>(given_up, tries, s.rejections);
        for (T *last : {&s.last_accepted, &s.last_height}) *last = select<T>(fresh | second, s.time, *last);
        s.settled = all(s.running);
    }
};

template <class T>
Step<T>::Step(const Composition<T> &composition)
    : c(composition), ahead(composition), estimation(composition), dimension(composition), scores(composition), hindsight(composition), before(composition) {
    const int hypotheses = ahead.pairwise() ? c.count * c.count : c.count;
    innovations.assign(hypotheses + c.declared.side.size(), nothing());
    if (ahead.pairwise()) posterior.resize(hypotheses), updated.resize(ahead.pairs.size());
    if (estimation.active()) always = with_innovations;
}

template <class T> Outcome<T> Step<T>::step(TrackState<T> &s, const Scan<T> &scan, int detail) {
    Outcome<T> out;
    const T zero = splat<T>(0.0);
    if (c.declared.coast > 0.0) {
        const Mask<T> lost = s.started & (scan.time - s.last_accepted > splat<T>(c.declared.coast));
        if (any(lost)) s.started = s.started & inverse(lost), s.running = s.running & inverse(lost), s.settled = false;
    }
    T dt = scan.time - s.time;
    if (!s.settled) dt = select<T>(s.started & inverse(is_nan(s.time)), dt, zero);
    dt = select<T>(scan.active, dt, zero);
    if (c.residuals) {
        const Fix<T> fix = position_of(scan);
        if (c.declared.outlier_share > 0.0) before = s;
        ahead(s, dt, scan.input, &fix);
    } else {
        if (hindsight.active()) hindsight.part(s, ahead, scan.active, dt, scan.input);
        ahead(s, dt, scan.input, nullptr);
    }
    s.time = select<T>(scan.active, scan.time, s.time);
    Measurement<T> m;
    if (!scan.sensor) {
        const Sensor<T> &sensor = c.sensors[scan.one_sensor];
        measure(scan, sensor, splat_mask<T>(true), m);
        update_modes(s, sensor, m, detail | always);
        finish(s, scan, sensor, m, splat_mask<T>(true), detail | always, out);
    } else {
        several(s, scan, detail | always, out);
    }
    if (dimension.active())
        dimension(s, position_of(scan), dt, innovations[0].nis, out.scored & inverse(out.gated), scan.active & s.running, out.initialised | out.restarted);
    else if (c.proposes()) ahead.proposal.close(s, scan.active);
    return out;
}

}  // namespace jink::inline JINK_LEVEL
