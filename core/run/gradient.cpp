#define JINK_UNROLL _Pragma("GCC unroll 1")
#include "run/gradient.hpp"

#include <memory>
#include <unordered_map>

#include "run/numbers.hpp"
#include "run/rows.hpp"
#include "run/threads.hpp"

namespace jink::inline JINK_LEVEL {

namespace {

using T = Slopes;

T constant(Pack value) { return T::of(value, [](int) { return Pack{}; }); }

// The filter with its numbers' slopes along up to K of the directions, from one on.
std::unique_ptr<Composition<T>> along(const Declaration &declaration, const double *tangents, int from, int directions) {
    std::unordered_map<const double *, std::size_t> places;
    each_number(declaration, [&](const double &number) { places.emplace(&number, places.size()); });
    return std::make_unique<Composition<T>>(declaration, [&](const double &number) {
        T lifted = splat<T>(number);
        const auto place = places.find(&number);
        for (int k = 0; place != places.end() && k < T::slopes && from + k < directions; ++k)
            lifted.slope[k] = splat<Pack>(tangents[(from + k) * places.size() + place->second]);
        return lifted;
    });
}

// One thread's work in one pass: all scans of a pack, with K slopes.
class Pass {
  public:
    Pass(const Composition<T> &composition, const BatchInput &input, const Objective &objective_)
        : c(composition), in(input), objective(objective_), step(c), forecast(c), combine(c), state(c), rows(in, c.declared.axes()),
          sums(objective.sums(in.columns)), target(objective.target, sums, NAN), weight(objective.weight, sums, 0.0),
          ahead(objective.figure == Figure::prediction_error && objective.ahead > 1 ? objective.ahead : 0, state), total(sums) {}

    const std::vector<T> &run(const std::int64_t *tracks, int used) {
        const std::int64_t longest = rows.take(tracks, used);
        state.reset(c);
        if (in.prior_x) begin_at_prior(c, in, state, tracks, used);
        for (auto &waiting : ahead) waiting = state, waiting.running = splat_mask<T>(false);
        for (auto &sum : total) sum = splat<T>(0.0);
        for (std::int64_t from = 0; from < longest; from += block) {
            const int scans = int(std::min<std::int64_t>(block, longest - from));
            rows.gather(from, scans), target.gather(rows.span, from, scans), weight.gather(rows.span, from, scans);
            for (int k = 0; k < scans; ++k) scan(k);
        }
        rows.verify(tracks, used);
        return total;
    }

  private:
    const Composition<T> &c;
    const BatchInput &in;
    const Objective &objective;
    Step<T> step;
    Propagate<T> forecast;
    Combine<T> combine;
    TrackState<T> state;
    Rows rows;
    int sums;
    Stream target, weight;
    std::vector<TrackState<T>> ahead;  // ahead[i]: the scan as predicted i + 1 scans before; none where one scan is enough
    std::vector<T> total;
    T x[largest_state];

    void scan(int k) {
        Scan<Pack> plain;
        Pack known[3];
        T input[3];
        rows.read(k, plain, known);
        Scan<T> s;
        s.time = constant(plain.time), s.active = plain.active;
        for (int r = 0; r < in.columns; ++r) s.z[r] = constant(plain.z[r]);
        s.own_noise = plain.own_noise, s.own_full = plain.own_full;
        const int terms = !in.noise ? 0 : in.full_noise ? packed_size(in.columns) : in.columns;
        for (int r = 0; r < terms; ++r) s.R[r] = constant(plain.R[r]);
        for (int a = 0; plain.input && a < c.declared.axes(); ++a) input[a] = constant(known[a]);
        s.input = plain.input ? input : nullptr;
        s.one_sensor = plain.one_sensor, s.sensor = plain.sensor;
        if (!ahead.empty()) predict_ahead(s);
        const Mask<T> running = state.running;
        const Outcome<T> o = step.step(state, s, Detail::plain);
        if (objective.figure == Figure::log_likelihood) add(k, 0, s.active & o.measured, o.log_likelihood);
        else if (objective.figure == Figure::tracking_error) tracking(k, s.active & state.running);
        else if (ahead.empty()) step.ahead.merge_pairs(), prediction(k, s, s.active & running, step.ahead.predicted, step.ahead.prior);
        else prediction(k, s, s.active & ahead.back().running, ahead.back().arena, ahead.back().probability);
    }

    void add(int k, int sum, Mask<T> counted, T figure) {
        if (objective.weight) figure = figure * constant(weight.at(k, sum)), counted = counted & (weight.at(k, sum) != Pack{});
        total[sum] = total[sum] + select<T>(counted, figure, splat<T>(0.0));
    }

    void tracking(int k, Mask<T> counted) {
        combine(state.arena.data(), state.probability.data(), x, nullptr);
        for (int r = 0; r < sums; ++r) {
            const Pack there = target.at(k, r);
            const T error = x[objective.components[r]] - constant(there);
            add(k, r, counted & inverse(is_nan(there)), error * error);
        }
    }

    void prediction(int k, const Scan<T> &s, Mask<T> counted, const std::vector<T> &arena, const std::vector<T> &probability) {
        combine(arena.data(), probability.data(), x, nullptr);
        for (int which = 0; which < int(c.sensors.size()); ++which) {
            Mask<T> mine = splat_mask<T>(!s.sensor && s.one_sensor == which);
            for (int l = 0; s.sensor && l < lanes; ++l) set_lane(mine, l, s.sensor[l] == which);
            if (!any(mine)) continue;
            const SensorSpec &spec = c.sensors[which].spec;
            T h[largest_measurement];
            observe(spec, c.reported.block, c.reported.n, x, h);
            residual(spec, s.z, h, h);
            for (int r = 0; r < spec.rows; ++r) add(k, r, counted & mine & inverse(is_nan(s.z[r])), h[r] * h[r]);
        }
    }

    // Everything under way moves on by one scan; the estimate of the scan before sets out.
    void predict_ahead(const Scan<T> &s) {
        const T dt = select<T>(s.active & state.started, s.time - state.time, splat<T>(0.0));
        const auto move = [&](const TrackState<T> &from, TrackState<T> &to) {
            to = from;
            forecast(to, dt, s.input, nullptr);
            forecast.merge_pairs();
            to.arena = forecast.predicted, to.probability = forecast.prior;
        };
        for (std::size_t i = ahead.size(); i-- > 1;) move(ahead[i - 1], ahead[i]);
        move(state, ahead[0]);
    }
};

}  // namespace

void run_gradient(const Declaration &declaration, const BatchInput &in, const Objective &objective, const double *tangents, int directions,
                  double *value, double *slope, int threads) {
    const int passes = std::max(1, (directions + T::slopes - 1) / T::slopes), sums = objective.sums(in.columns);
    std::vector<std::unique_ptr<Composition<T>>> filters;
    for (int p = 0; p < passes; ++p) filters.push_back(along(declaration, tangents, p * T::slopes, directions));
    const std::vector<std::int64_t> order = longest_first(in);
    over_threads(packs_of(in) * passes, threads, [&] {
        return [&, workers = std::vector<std::unique_ptr<Pass>>(passes)](std::int64_t item) mutable {
            const std::int64_t pack = item / passes;
            const int p = int(item % passes), used = int(std::min<std::int64_t>(lanes, in.tracks - pack * lanes));
            if (!workers[p]) workers[p] = std::make_unique<Pass>(*filters[p], in, objective);
            const std::vector<T> &total = workers[p]->run(&order[pack * lanes], used);
            for (int l = 0; l < used; ++l)
                for (int r = 0; r < sums; ++r) {
                    const std::int64_t at = order[pack * lanes + l] * sums + r;
                    if (p == 0) value[at] = lane(total[r].value, l);
                    for (int k = 0; k < T::slopes && p * T::slopes + k < directions; ++k)
                        slope[(p * T::slopes + k) * in.tracks * sums + at] = lane(total[r].slope[k], l);
                }
        };
    });
}

}  // namespace jink::inline JINK_LEVEL
