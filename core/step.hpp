// One scan of one track (or one pack of tracks): mix, predict, update, weigh. What combine.hpp makes of it goes out.
#pragma once

#include "start.hpp"

namespace jink::inline JINK_LEVEL {

// What the update sees of a sensor: of a converted one, a position.
template <class T> SensorSpec seen(const Sensor<T> &sensor) {
    SensorSpec spec = sensor.spec;
    if (sensor.converted) spec.kind = SensorKind::position, spec.rows = spec.axes;
    return spec;
}

template <class T> class Step {
  public:
    explicit Step(const Composition<T> &composition) : c(composition) {
        const int m = c.count;
        predicted.resize(c.arena_size);
        pi.resize(m * m), weights.resize(m * m), prior.resize(m), log_prior.resize(m);
        coefficients.resize(m * largest_coefficients);
        innovations.resize(m);
        last_dt = nan_of<T>();
    }

    const Composition<T> &c;
    std::vector<T> predicted;  // each mode's x- and P-, at the mode's place
    std::vector<T> prior;      // mode probabilities before the measurement

    // Elapsed-time coefficients and transition matrix; kept while the step stays the same.
    void elapse(T dt) {
        if (all(dt == last_dt)) return;
        last_dt = dt;
        for (int j = 0; j < c.count; ++j)
            c.modes[j].kernels.prepare(c.modes[j].motion, dt, c.modes[j].parameters.data(), coefficient(j));
        c.transition.over(dt, pi.data());
    }
    const T *coefficient(int j) const { return &coefficients[j * largest_coefficients]; }
    T *coefficient(int j) { return &coefficients[j * largest_coefficients]; }
    const T *transition() const { return pi.data(); }

    void propagate(TrackState<T> &s, T dt, const T *input) {
        elapse(dt);
        const int m = c.count;
        if (m == 1) {
            prior[0] = splat<T>(1.0);
            c.modes[0].kernels.predict(&s.arena[c.modes[0].place], coefficient(0), input, &predicted[c.modes[0].place]);
            return;
        }
        const T least = splat<T>(1e-100);  // a mode never dies for good
        for (int j = 0; j < m; ++j) prior[j] = splat<T>(0.0);
        for (int i = 0; i < m; ++i) {
            const T mu = larger<T>(s.probability[i], least);
            for (int j = 0; j < m; ++j) weights[j * m + i] = pi[i * m + j] * mu, prior[j] = prior[j] + weights[j * m + i];
        }
        for (int j = 0; j < m; ++j) {
            const Mode<T> &mode = c.modes[j];
            const T over = reciprocal(prior[j]);
            for (int i = 0; i < m; ++i) weights[j * m + i] = weights[j * m + i] * over;
            T *at = &predicted[mode.place];
            mode.mix(s.arena.data(), mode.sources.data(), &weights[j * m], m, at);
            mode.kernels.predict(at, coefficient(j), input, at);
        }
    }

    Outcome<T> step(TrackState<T> &s, const Scan<T> &scan, int detail) {
        Outcome<T> out;
        const T zero = splat<T>(0.0);
        if (c.declared.coast > 0.0) {
            const Mask<T> lost = s.started & (scan.time - s.last_accepted > splat<T>(c.declared.coast));
            if (any(lost)) s.started = s.started & inverse(lost), s.running = s.running & inverse(lost), s.settled = false;
        }
        T dt = scan.time - s.time;
        if (!s.settled) dt = select<T>(s.started & inverse(is_nan(s.time)), dt, zero);
        dt = select<T>(scan.active, dt, zero);
        propagate(s, dt, scan.input);
        s.time = select<T>(scan.active, scan.time, s.time);
        Measurement<T> m;
        if (!scan.sensor) {
            const Sensor<T> &sensor = c.sensors[scan.one_sensor];
            measure(scan, sensor, splat_mask<T>(true), m);
            update_modes(s, sensor, m, detail);
            finish(s, scan, sensor, m, detail, out);
        } else {
            several(s, scan, detail, out);
        }
        return out;
    }

    // The measurement as the sensor's update wants it; a converted one becomes a position with a full covariance.
    void measure(const Scan<T> &scan, const Sensor<T> &sensor, Mask<T> lanes_of_it, Measurement<T> &m) const {
        const SensorSpec &spec = sensor.spec;
        const Mask<T> usable = scan.active & lanes_of_it;
        for (int r = 0; r < spec.rows; ++r) m.z[r] = scan.z[r], m.present[r] = usable & inverse(is_nan(scan.z[r]));
        m.full = scan.own_noise ? scan.own_full : spec.correlated;
        const T *noise = scan.own_noise ? scan.R : sensor.noise.data();
        const int terms = m.full ? packed_size(spec.rows) : spec.rows;
        for (int k = 0; k < terms; ++k) m.R[k] = noise[k];
        if (!sensor.converted) return;
        const Fix<T> fix = position_fix(spec, m);
        for (int a = 0; a < spec.axes; ++a) m.z[a] = fix.p[a], m.present[a] = fix.position;
        for (int k = 0; k < packed_size(spec.axes); ++k) m.R[k] = fix.P[k];
        m.full = true;
    }

  private:
    std::vector<T> pi, weights, log_prior, coefficients;
    std::vector<Innovation<T>> innovations;
    T last_dt;

    void update_modes(TrackState<T> &s, const Sensor<T> &sensor, const Measurement<T> &m, int detail) {
        const SensorSpec spec = seen(sensor);
        for (int j = 0; j < c.count; ++j) {
            const Mode<T> &mode = c.modes[j];
            const UpdateKernels<T> &k = mode.update;
            UpdateKernel<T> kernel = k.general;
            if (spec.linear()) kernel = spec.kind == SensorKind::position ? k.position : k.position_velocity;
            else if (!spec.linear() && c.declared.unscented) kernel = k.unscented;
            kernel(spec, m, &predicted[mode.place], &s.arena[mode.place], innovations[j], detail != plain);
        }
    }

    // Lanes with different sensors: each sensor's lanes are stepped as if they were alone, the others kept.
    void several(TrackState<T> &s, const Scan<T> &scan, int detail, Outcome<T> &out) {
        const TrackState<T> before = s;
        TrackState<T> after = s;
        for (int sensor = 0; sensor < int(c.sensors.size()); ++sensor) {
            Mask<T> mine = splat_mask<T>(false);
            for (int l = 0; l < width<T>; ++l) set_lane(mine, l, scan.sensor[l] == sensor);
            if (!any(mine)) continue;
            TrackState<T> trial = before;
            Outcome<T> part;
            Measurement<T> m;
            measure(scan, c.sensors[sensor], mine, m);
            update_modes(trial, c.sensors[sensor], m, detail);
            finish(trial, scan, c.sensors[sensor], m, detail, part);
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
        take(to.last_accepted, from.last_accepted), take(to.first_time, from.first_time), take(to.rejections, from.rejections);
        for (int k = 0; k < 3; ++k) take(to.first[k], from.first[k]);
        for (int k = 0; k < 6; ++k) take(to.first_P[k], from.first_P[k]);
        take_mask(to.started, from.started), take_mask(to.running, from.running);
        take(out.log_likelihood, part.log_likelihood), take(out.dof, part.dof), take(out.nis, part.nis);
        for (int r = 0; r < largest_measurement; ++r) take(out.pit[r], part.pit[r]);
        take_mask(out.measured, part.measured), take_mask(out.scored, part.scored), take_mask(out.gated, part.gated);
        take_mask(out.restarted, part.restarted), take_mask(out.initialised, part.initialised);
    }

    // Bayes' rule over the modes, gating, and the start of tracks that need one.
    void finish(TrackState<T> &s, const Scan<T> &scan, const Sensor<T> &sensor, const Measurement<T> &m, int detail, Outcome<T> &out) {
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
        out.gated = out.restarted = out.initialised = splat_mask<T>(false);
        out.scored = out.measured & s.running;
        if (detail & with_nis) out.nis = matched_nis(spec.rows, m.present);
        if (detail & with_pit) {
            for (auto &value : out.pit) value = nan_of<T>();
            transform(spec.rows, m.present, out.pit);
        }
        weigh(s, dof, out);
        if (c.declared.outlier_share > 0.0) gate(s, log_outlier, out);
        s.last_accepted = select<T>(out.measured & inverse(out.gated), s.time, s.last_accepted);
        if (!s.settled || any(out.restarted)) begin(s, sensor.spec, scan, sensor, out);
    }

    void weigh(TrackState<T> &s, T dof, Outcome<T> &out) {
        constexpr double log_two_pi = 1.83787706640934548356;
        const int n = c.count;
        if (n == 1) {
            out.log_likelihood = -0.5 * (innovations[0].nis + logarithm<T>(innovations[0].det) + log_two_pi * dof);
        } else {
            // c_j N_j / max over exp(-nis/2) of the best fitting mode, which cannot all underflow
            T least = innovations[0].nis;
            for (int j = 1; j < n; ++j) least = smaller<T>(innovations[j].nis, least);
            T sum = splat<T>(0.0);
            for (int j = 0; j < n; ++j) {
                const Innovation<T> &v = innovations[j];
                s.probability[j] = prior[j] * reciprocal_root(v.det) * exponential<T>(0.5 * (least - v.nis));
                sum = sum + s.probability[j];
            }
            const T over = reciprocal(sum);
            for (int j = 0; j < n; ++j) s.probability[j] = s.probability[j] * over;
            out.log_likelihood = logarithm<T>(sum) - 0.5 * (least + log_two_pi * dof);
        }
        out.log_likelihood = select<T>(out.measured, out.log_likelihood, splat<T>(0.0));
    }

    // A measurement is either the target's, with the innovation's density over all modes, or an outlier, uniform over the
    // sensor's extent. The likelihood is that of the mixture; at run time the likelier of the two is believed.
    void gate(TrackState<T> &s, T log_outlier, Outcome<T> &out) {
        const double share = c.declared.outlier_share;
        const T target = out.log_likelihood + std::log1p(-share), outlier = log_outlier + std::log(share);
        const T high = larger<T>(target, outlier), low = smaller<T>(target, outlier);
        const T mixture = high + logarithm<T>(1.0 + exponential<T>(low - high));
        out.log_likelihood = select<T>(out.measured, mixture, out.log_likelihood);
        out.gated = out.measured & (target < outlier) & s.running;
        s.rejections = select<T>(out.measured, select<T>(out.gated, s.rejections + 1.0, splat<T>(0.0)), s.rejections);
        if (!any(out.gated)) return;
        for (int j = 0; j < c.count; ++j) {
            const Mode<T> &mode = c.modes[j];
            for (int k = mode.place; k < mode.place + mode.size(); ++k)
                s.arena[k] = select<T>(out.gated, predicted[k], s.arena[k]);
            s.probability[j] = select<T>(out.gated, prior[j], s.probability[j]);
        }
        if (c.declared.restart_after > 0)
            out.restarted = out.gated & (s.rejections >= splat<T>(c.declared.restart_after));
    }

    // NIS of the innovation moment-matched over the modes.
    T matched_nis(int rows, const Mask<T> *present) const {
        T y[largest_measurement], S[packed_size(largest_measurement)], L[packed_size(largest_measurement)];
        const T zero = splat<T>(0.0);
        for (int r = 0; r < rows; ++r) {
            y[r] = zero;
            for (int j = 0; j < c.count; ++j) y[r] = y[r] + prior[j] * innovations[j].y[r];
        }
        for (int r = 0; r < rows; ++r)
            for (int q = 0; q <= r; ++q) {
                T sum = zero;
                for (int j = 0; j < c.count; ++j) {
                    const Innovation<T> &v = innovations[j];
                    sum = sum + prior[j] * (v.joint[packed(r, q)] + (v.y[r] - y[r]) * (v.y[q] - y[q]));
                }
                S[packed(r, q)] = sum;
            }
        cholesky<T>(rows, S, L);
        solve_lower<T>(rows, L, y);
        T nis = zero;
        for (int r = 0; r < rows; ++r) nis = nis + select<T>(present[r], y[r] * y[r], zero);
        return nis;
    }

    // Rosenblatt's transform of the measurement under the mixture: independent and uniform if the filter is consistent.
    void transform(int rows, const Mask<T> *present, T *pit) {
        for (int j = 0; j < c.count; ++j) log_prior[j] = logarithm<T>(larger<T>(prior[j], splat<T>(1e-300)));
        for (int r = 0; r < rows; ++r) {
            T most = log_prior[0], sum = splat<T>(0.0), below = sum;
            for (int j = 1; j < c.count; ++j) most = larger<T>(most, log_prior[j]);
            for (int j = 0; j < c.count; ++j) {
                const Innovation<T> &v = innovations[j];
                const T w = exponential<T>(log_prior[j] - most), u = v.e[r] / square_root(v.S[r]);
                sum = sum + w, below = below + w * normal_cdf<T>(u);
                log_prior[j] = log_prior[j] - 0.5 * (u * u + logarithm<T>(v.S[r]));
            }
            pit[r] = select<T>(present[r], below / sum, nan_of<T>());
        }
    }

    // Tracks without a state start from one measured position; the second position completes a two-point start.
    void begin(TrackState<T> &s, const SensorSpec &spec, const Scan<T> &scan, const Sensor<T> &sensor, Outcome<T> &out) {
        Measurement<T> m;
        Sensor<T> raw = sensor;
        raw.converted = false;
        measure(scan, raw, splat_mask<T>(true), m);
        const Fix<T> fix = position_fix(spec, m);
        const Mask<T> fresh = scan.active & fix.position & (inverse(s.started) | out.restarted);
        const Mask<T> second = scan.active & fix.position & s.started & inverse(s.running) & inverse(out.restarted);
        const bool two_point = c.declared.start == Start::two_point;
        if (any(second)) complete(c, s, fix, second);
        if (any(fresh)) {
            start(c, s, fix, fresh);
            const Mask<T> done = two_point ? fix.velocity | out.restarted : splat_mask<T>(true);
            s.running = (s.running & inverse(fresh)) | (fresh & done);
        }
        out.initialised = fresh | (second & s.running);
        out.restarted = out.restarted & fresh;
        const Mask<T> counted = out.scored | out.restarted;
        out.log_likelihood = select<T>(counted, out.log_likelihood, splat<T>(0.0));
        out.scored = out.scored & inverse(fresh);
        s.started = s.started | fresh;
        s.rejections = select<T>(fresh, splat<T>(0.0), s.rejections);
        s.last_accepted = select<T>(fresh | second, s.time, s.last_accepted);
        s.settled = all(s.running);
    }
};

}  // namespace jink::inline JINK_LEVEL
