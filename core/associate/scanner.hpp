// What one pack of tracks has to do with a scan: predict, find plots within the gates, weigh them, and take them in.
#pragma once

#include "associate/plots.hpp"
#include "associate/pool.hpp"
#include "scan/combine.hpp"

namespace jink::inline JINK_LEVEL {

// A plot within the gate of some mode: log sum_m mu_m N(z; z_m, S_m), and the least squared distance over the modes.
struct Candidate {
    int plot;
    double log_likelihood, distance2;
};

// What a track takes in: plots by their weight, the rest of it "no plot"; the weights sum to one.
struct Share {
    int plot;
    double weight;
};

// Which plots a track looks at: those within d2 < square in some mode. A sure track also looks farther, at plots that are
// likelier to be its own than to be false while it is missed: log(Pd l / ((1 - Pd) ground)) > 0, the maximum likelihood gate
// (Blackman, Multiple-Target Tracking with Radar Applications, 1986). Where clutter is sparse, an unforeseen turn stays in it.
struct Gate {
    double square = 16.0;
    double log_odds = -INFINITY;  // log(Pd / ((1 - Pd) ground)); ground: density of plots that are no track's

    // The square within which a plot may be likelier, for variances of the innovation along the axes.
    template <class T> T widest(T xx, T yy) const {
        constexpr double log_two_pi = 1.83787706640934548356;
        return larger<T>(splat<T>(2.0 * (log_odds - log_two_pi)) - logarithm<T>(xx * yy), splat<T>(square));
    }
};

class Scanner {
  public:
    explicit Scanner(const Composition<Pack> &composition)
        : c(composition), step(composition), combine(composition), innovations(composition.count), mode_share(composition.count) {
        for (auto &v : innovations) v = Innovation<Pack>();
        scratch.resize(c.arena_size);
    }

    // When each lane's track is seen in a scan that takes time: with the nearest plot near where it will be, else in the middle.
    Pack expected(const TrackPack &pack, const Plots &plots, double middle, const Gate &gate, const bool *live, const bool *sure) {
        const TrackState<Pack> &s = pack.state;
        Pack x[largest_state], P[packed_size(largest_state)], when = splat<Pack>(middle);
        combine(s.arena.data(), s.probability.data(), x, P);
        const int block = c.reported.block, axes = std::min(c.reported.axes, 2);
        for (int l = 0; l < lanes; ++l) {
            if (!live[l]) continue;
            double low[2] = {-INFINITY, -INFINITY}, high[2] = {INFINITY, INFINITY}, least = INFINITY;
            double mean[2][2], variance[2][2], square[2];
            // From the first plot to the last the target moves; the spread is largest at an end.
            for (int end = 0; end < 2; ++end) {
                const double dt = (end ? plots.latest : plots.earliest) - s.time[l];
                for (int a = 0; a < axes; ++a) {
                    const int p = a * block, v = p + 1;
                    mean[end][a] = x[p][l] + dt * x[v][l];
                    variance[end][a] = P[packed(p, p)][l] + dt * (2.0 * P[packed(v, p)][l] + dt * P[packed(v, v)][l]) + plots.largest[a];
                }
                square[end] = sure[l] && axes > 1 ? gate.widest<double>(variance[end][0], variance[end][1]) : gate.square;
            }
            for (int a = 0; a < axes; ++a) {
                const double first = std::sqrt(square[0] * variance[0][a]), last = std::sqrt(square[1] * variance[1][a]);
                low[a] = std::min(mean[0][a] - first, mean[1][a] - last), high[a] = std::max(mean[0][a] + first, mean[1][a] + last);
            }
            plots.within(low, high, [&](int j) {
                double far = 0.0;
                for (int a = 0; a < axes; ++a) {
                    // at the plot's own time
                    const double e = plots.fix[j].p[a] - x[a * block][l] - (plots.time[j] - s.time[l]) * x[a * block + 1][l];
                    far += e * e;
                }
                if (far < least) least = far, when[l] = plots.time[j];
            });
        }
        return larger<Pack>(when, s.time);
    }

    // The pack at these times, its modes mixed and predicted.
    void predict(TrackPack &pack, Pack now) {
        TrackState<Pack> &s = pack.state;
        pack.dt = now - s.time;
        if (c.residuals) pack.carry = s.carry;
        step.ahead(s, pack.dt, nullptr, nullptr);
        s.time = now;
        pack.predicted.swap(step.ahead.predicted), pack.prior = step.ahead.prior;
    }

    // Candidates of every lane, in the order of plots; at most `most`, those nearest the middle of the gate. True if some were left out.
    bool look(const TrackPack &pack, const Plots &plots, int sensor, const Gate &gate, int most, const bool *live, const bool *sure,
              std::vector<Candidate> *found) {
        bool crowded = false;
        int longest = 0;
        Pack lower[2], upper[2];
        box(pack, plots, gate, sure, lower, upper);
        for (int l = 0; l < lanes; ++l) {
            near[l].clear(), found[l].clear();
            if (!live[l]) continue;
            const double low[2] = {lower[0][l], lower[1][l]}, high[2] = {upper[0][l], upper[1][l]};
            plots.within(low, high, [&](int j) { near[l].push_back(j); });
            if (int(near[l].size()) > most) crowded = true, nearest(plots, low, high, most, near[l]);
            std::sort(near[l].begin(), near[l].end());
            longest = std::max(longest, int(near[l].size()));
        }
        for (int k = 0; k < longest; ++k) {
            const Mask<Pack> mine = bring(plots, sensor, [&](int l) { return k < int(near[l].size()) ? near[l][k] : -1; });
            weigh(pack, sensor);
            for (int l = 0; l < lanes; ++l) {
                if (!lane(mine, l)) continue;
                const int j = near[l][k];
                const bool likely = sure[l] && log_likelihood[l] - plots.log_unit[j] + gate.log_odds > 0.0;
                if (closest[l] < gate.square || likely) found[l].push_back({j, log_likelihood[l], closest[l]});
            }
        }
        return crowded;
    }

    // Each lane's estimate becomes the mixture of its predictions updated by its plots, and of the prediction itself; per mode
    // matched in two moments.
    void take_in(TrackPack &pack, const Plots &plots, int sensor, const std::vector<Share> *shares) {
        int longest = 0;
        for (int l = 0; l < lanes; ++l) longest = std::max(longest, int(shares[l].size()));
        TrackState<Pack> &s = pack.state;
        if (c.residuals) adapt(pack, plots, shares);
        const int m = c.count, n = longest + 1;
        branches.resize(std::size_t(n) * c.arena_size), weights.resize(std::size_t(m) * n);
        std::copy(pack.predicted.begin(), pack.predicted.end(), branches.begin());
        Pack rest = splat<Pack>(1.0);
        for (int k = 0; k < longest; ++k) {
            const auto of = [&](int l) { return k < int(shares[l].size()) ? shares[l][k].plot : -1; };
            const Mask<Pack> mine = bring(plots, sensor, of);
            Pack *out = &branches[std::size_t(k + 1) * c.arena_size];
            update(pack, sensor, out);
            weigh_modes(pack);
            Pack share = splat<Pack>(0.0);
            for (int l = 0; l < lanes; ++l)
                if (lane(mine, l)) share[l] = shares[l][k].weight;
            rest = rest - share;
            for (int j = 0; j < m; ++j) weights[j * n + k + 1] = share * mode_share[j];
        }
        rest = larger<Pack>(rest, splat<Pack>(0.0));
        for (int j = 0; j < m; ++j) {
            Pack *w = &weights[j * n], sum = w[0] = rest * pack.prior[j];
            for (int k = 1; k < n; ++k) sum = sum + w[k];
            s.probability[j] = sum;
            const Pack over = reciprocal(larger<Pack>(sum, splat<Pack>(1e-300)));
            const Mask<Pack> dead = sum < splat<Pack>(1e-300);
            for (int k = 0; k < n; ++k) w[k] = select<Pack>(dead, splat<Pack>(1.0 / n), w[k] * over);
            const Mode<Pack> &mode = c.modes[j];
            places.resize(std::size_t(n) * mode.size());
            for (int k = 0; k < n; ++k) places[std::size_t(k) * mode.size()] = k * c.arena_size + mode.place;
            mix_kernel<Pack, true>(mode.shape.n)(branches.data(), places.data(), w, n, &s.arena[mode.place]);
        }
    }

    // New tracks in the lanes that have a plot, from its position, with no velocity but the sensor's.
    void begin(TrackPack &pack, const Plots &plots, const int *plot_of) {
        Fix<Pack> fix;
        for (int k = 0; k < 6; ++k) fix.P[k] = fix.V[k] = splat<Pack>(1.0);
        for (int a = 0; a < 3; ++a) fix.p[a] = fix.v[a] = splat<Pack>(0.0);
        fix.position = fix.velocity = splat_mask<Pack>(false);
        for (int l = 0; l < lanes; ++l) {
            if (plot_of[l] < 0) continue;
            const Fix<double> &one = plots.fix[plot_of[l]];
            for (int a = 0; a < 3; ++a) fix.p[a][l] = one.p[a], fix.v[a][l] = one.v[a];
            for (int k = 0; k < 6; ++k) fix.P[k][l] = one.P[k], fix.V[k][l] = one.V[k];
            set_lane(fix.position, l, true), set_lane(fix.velocity, l, one.velocity);
        }
        TrackState<Pack> &s = pack.state;
        start(c, s, fix, fix.position);
        s.started = s.started | fix.position, s.running = s.running | fix.position;
        s.settled = true;
    }

    const Composition<Pack> &c;
    Step<Pack> step;
    Combine<Pack> combine;

  private:
    std::vector<Innovation<Pack>> innovations;
    std::vector<Pack> mode_share;  // of each mode, its share of the likelihood of the plot
    std::vector<Pack> scratch, branches, weights;
    std::vector<int> places, near[lanes];
    Measurement<Pack> m;
    Pack log_likelihood, closest, dof;

    // Of each lane the box around the gates of all modes.
    void box(const TrackPack &pack, const Plots &plots, const Gate &gate, const bool *sure, Pack *low, Pack *high) const {
        Mask<Pack> farther = splat_mask<Pack>(false);
        for (int l = 0; l < lanes; ++l) set_lane(farther, l, sure[l]);
        for (int a = 0; a < 2; ++a) low[a] = splat<Pack>(INFINITY), high[a] = splat<Pack>(-INFINITY);
        for (int j = 0; j < c.count; ++j) {
            const Mode<Pack> &mode = c.modes[j];
            const Pack *x = &pack.predicted[mode.place], *P = x + mode.shape.n;
            const int axes = std::min(mode.shape.axes, 2), block = mode.shape.block;
            Pack variance[2], square = splat<Pack>(gate.square);
            for (int a = 0; a < axes; ++a) variance[a] = P[packed(a * block, a * block)] + splat<Pack>(plots.largest[a]);
            if (axes > 1) square = select<Pack>(farther, gate.widest<Pack>(variance[0], variance[1]), square);
            for (int a = 0; a < axes; ++a) {
                const Pack middle = x[a * block], far = square_root(square * variance[a]);
                low[a] = smaller<Pack>(low[a], middle - far), high[a] = larger<Pack>(high[a], middle + far);
            }
            for (int a = axes; a < 2; ++a) low[a] = splat<Pack>(-INFINITY), high[a] = splat<Pack>(INFINITY);
        }
    }

    // Modes whose noise follows the residual are predicted again, now that it is known: of the mean of the track's plots.
    void adapt(TrackPack &pack, const Plots &plots, const std::vector<Share> *shares) {
        Fix<Pack> fix;
        for (int k = 0; k < 6; ++k) fix.P[k] = fix.V[k] = splat<Pack>(1.0);
        for (int a = 0; a < 3; ++a) fix.p[a] = fix.v[a] = splat<Pack>(0.0);
        fix.position = fix.velocity = splat_mask<Pack>(false);
        for (int l = 0; l < lanes; ++l) {
            double sum = 0.0;
            for (const Share &each : shares[l]) sum += each.weight;
            // What more probably has no plot is a miss.
            if (!(sum > 0.5)) continue;
            set_lane(fix.position, l, true);
            for (int k = 0; k < 6; ++k) fix.P[k][l] = 0.0;
            for (const Share &each : shares[l]) {
                const Fix<double> &one = plots.fix[each.plot];
                for (int a = 0; a < 3; ++a) fix.p[a][l] += each.weight / sum * one.p[a];
                for (int k = 0; k < 6; ++k) fix.P[k][l] += each.weight / sum * one.P[k];
            }
        }
        TrackState<Pack> &s = pack.state;
        s.carry = pack.carry;
        step.ahead(s, pack.dt, nullptr, &fix);
        pack.predicted.swap(step.ahead.predicted), pack.prior = step.ahead.prior;
    }

    static void nearest(const Plots &plots, const double *low, const double *high, int most, std::vector<int> &some) {
        const auto far = [&](int j) {
            double sum = 0.0;
            for (int a = 0; a < 2; ++a) {
                const double d = (2.0 * plots.fix[j].p[a] - low[a] - high[a]) / (high[a] - low[a]);
                sum += std::isfinite(d) ? d * d : 0.0;
            }
            return sum;
        };
        std::nth_element(some.begin(), some.begin() + most, some.end(), [&](int a, int b) {
            const double fa = far(a), fb = far(b);
            return fa != fb ? fa < fb : a < b;
        });
        some.resize(most);
    }

    // The measurement of each lane's plot; lanes without one miss. Returns the lanes that have one.
    template <class F> Mask<Pack> bring(const Plots &plots, int sensor, F plot_of) {
        Scan<Pack> scan;
        Mask<Pack> mine = splat_mask<Pack>(false);
        const int columns = c.declared.columns();
        scan.own_noise = plots.terms > 0, scan.own_full = plots.full;
        for (int r = 0; r < columns; ++r) scan.z[r] = nan_of<Pack>();
        for (int k = 0; k < plots.terms; ++k) scan.R[k] = splat<Pack>(1.0);
        if (plots.full)
            for (int r = 0; r < columns; ++r)
                for (int q = 0; q < r; ++q) scan.R[packed(r, q)] = splat<Pack>(0.0);
        for (int l = 0; l < lanes; ++l) {
            const int j = plot_of(l);
            if (j < 0) continue;
            set_lane(mine, l, true);
            for (int r = 0; r < plots.columns; ++r) scan.z[r][l] = plots.z[std::size_t(j) * plots.columns + r];
            for (int k = 0; k < plots.terms; ++k) scan.R[k][l] = plots.noise[std::size_t(j) * plots.terms + k];
        }
        scan.active = mine;
        step.measure(scan, c.sensors[sensor], splat_mask<Pack>(true), m);
        return mine;
    }

    void update(const TrackPack &pack, int sensor, Pack *out) {
        const SensorSpec spec = seen(c.sensors[sensor]);
        dof = splat<Pack>(0.0);
        for (int r = 0; r < spec.rows; ++r) dof = dof + select<Pack>(m.present[r], splat<Pack>(1.0), splat<Pack>(0.0));
        for (int j = 0; j < c.count; ++j) {
            const Mode<Pack> &mode = c.modes[j];
            const UpdateKernels<Pack> &k = mode.update;
            const UpdateKernel<Pack> linear = spec.kind == SensorKind::position ? k.position : k.position_velocity;
            const UpdateKernel<Pack> kernel = spec.linear() ? linear : c.declared.unscented ? k.unscented : k.general;
            kernel(spec, m, &pack.predicted[mode.place], out + mode.place, innovations[j], false);
        }
    }

    // Each mode's share mu_m N_m / sum mu N; `closest` and `log_likelihood` on the way.
    void weigh_modes(const TrackPack &pack) {
        constexpr double log_two_pi = 1.83787706640934548356;
        closest = innovations[0].nis;
        for (int j = 1; j < c.count; ++j) closest = smaller<Pack>(innovations[j].nis, closest);
        Pack sum = splat<Pack>(0.0);
        for (int j = 0; j < c.count; ++j) {
            const Innovation<Pack> &v = innovations[j];
            mode_share[j] = pack.prior[j] * reciprocal_root(v.det) * exponential<Pack>(0.5 * (closest - v.nis));
            sum = sum + mode_share[j];
        }
        const Pack over = reciprocal(sum);
        for (int j = 0; j < c.count; ++j) mode_share[j] = mode_share[j] * over;
        log_likelihood = logarithm<Pack>(sum) - 0.5 * (closest + log_two_pi * dof);
    }

    void weigh(const TrackPack &pack, int sensor) {
        update(pack, sensor, scratch.data());
        weigh_modes(pack);
    }
};

}  // namespace jink::inline JINK_LEVEL
