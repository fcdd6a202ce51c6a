// Live tracking: one target (double) or many at once (Pack), scan by scan, with a fixed lag if wanted.
#pragma once

#include <deque>
#include <memory>
#include <mutex>

#include "run/batch.hpp"
#include "run/fingerprint.hpp"

namespace jink::inline JINK_LEVEL {

// What one update leaves of one target; states are combined only when looked at.
template <class T> struct Snapshot {
    T time;
    std::vector<T> arena, probability, alive, correction;
    Outcome<T> outcome;
    Mask<T> started;
    T doubt = splat<T>(0.0);  // that the measurement is an outlier, where the next one decides; else 0
};

template <class T> class Live {
  public:
    Live(std::shared_ptr<const Composition<T>> composition, int targets, int lag_scans)
        : c(std::move(composition)), step(*c), aid(*c), back(*c), n(targets), lag(lag_scans),
          states((targets + width<T> - 1) / width<T>, TrackState<T>(*c)), history(lag > 0 ? states.size() : 0) {}

    Live(const Live &) = delete;  // a track is one

    const std::shared_ptr<const Composition<T>> c;
    mutable std::mutex busy;  // held by whoever reads or changes the tracks
    int targets() const { return n; }
    int lag_scans() const { return lag; }
    int packs() const { return int(states.size()); }

    // Row-wise input of all targets: z (n, columns); t one for all or one each; noise and input as in a batch, or null.
    struct Rows {
        const double *time;
        bool one_time;
        const double *z;
        const std::int32_t *sensor = nullptr;
        int one_sensor = 0;
        const double *noise = nullptr;
        bool full_noise = false;
        const double *input = nullptr;
    };

    void update(int pack, const Rows &rows, int detail, Snapshot<T> &out) {
        TrackState<T> &s = states[pack];
        const int columns = c->declared.columns(), axes = c->declared.axes();
        Scan<T> scan;
        T input[3];
        std::int32_t which[width<T>];
        bool differ = false;
        const int terms = !rows.noise ? 0 : rows.full_noise ? columns * columns : columns;
        scan.own_noise = terms > 0, scan.own_full = rows.full_noise;
        scan.input = rows.input ? input : nullptr;
        for (int l = 0; l < width<T>; ++l) {
            const int at = pack * width<T> + l;
            const bool live = at < n;
            const int row = live ? at : n - 1;
            set_lane(scan.time, l, rows.time[rows.one_time ? 0 : row]);
            set_lane(scan.active, l, live);
            which[l] = rows.sensor ? rows.sensor[row] : rows.one_sensor;
            differ = differ || which[l] != which[0];
            for (int r = 0; r < columns; ++r) set_lane(scan.z[r], l, live ? rows.z[row * columns + r] : NAN);
            for (int k = 0; k < terms; ++k) {
                if (!rows.full_noise) set_lane(scan.R[k], l, rows.noise[row * columns + k]);
                else if (k % columns <= k / columns) set_lane(scan.R[packed(k / columns, k % columns)], l, rows.noise[row * terms + k]);
            }
            for (int a = 0; a < axes && rows.input; ++a) set_lane(input[a], l, rows.input[row * axes + a]);
        }
        scan.one_sensor = which[0];
        if (differ) scan.sensor = which;
        const T before = s.time;
        out.outcome = step.step(s, scan, detail);
        out.doubt = s.doubt;
        if (aid.active() && lag == 0) aid(step, s, scan, out.outcome), out.correction = aid.correction;
        if (lag > 0) {
            delay(pack, scan, before, out);
        } else {
            out.time = s.time, out.arena = s.arena, out.probability = s.probability, out.alive = s.alive, out.started = s.started;
        }
    }

    // Where the targets will be at a time, or were expected to be; the live state is not touched.
    void predict(int pack, const double *time, bool one_time, Snapshot<T> &out) {
        const TrackState<T> &s = states[pack];
        T to;
        for (int l = 0; l < width<T>; ++l) set_lane(to, l, time[one_time ? 0 : std::min(pack * width<T> + l, n - 1)]);
        TrackState<T> copy = s;
        step.ahead(copy, select<T>(s.started, to - s.time, splat<T>(0.0)), nullptr, nullptr);
        step.ahead.merge_pairs();
        out.time = to, out.arena = step.ahead.predicted, out.probability = step.ahead.prior, out.alive = copy.next, out.started = s.started;
        out.correction = lag == 0 ? aid.at(s, to) : std::vector<T>{};
        out.doubt = splat<T>(0.0), out.outcome.decided = out.outcome.upheld = splat_mask<T>(false);
        out.outcome.measured = out.outcome.scored = out.outcome.gated = out.outcome.restarted = out.outcome.initialised = splat_mask<T>(false);
        out.outcome.log_likelihood = splat<T>(0.0), out.outcome.nis = nan_of<T>(), out.outcome.dof = splat<T>(0.0);
    }

    double time_of(int target) const { return lane(states[target / width<T>].time, target % width<T>); }
    bool started(int target) const { return lane(states[target / width<T>].started, target % width<T>); }
    void reset(int target) {
        TrackState<T> &s = states[target / width<T>];
        set_lane(s.started, target % width<T>, false);
        set_lane(s.running, target % width<T>, false);
        s.settled = false;
    }
    void begin(int target, const double *x, const double *P, double time) {
        TrackState<T> &s = states[target / width<T>];
        set_prior(*c, s, target % width<T>, x, P, time);
        s.settled = all(s.running) && !std::isnan(time);  // without a time the first scan's is meant
    }

    // A target's state as plain numbers, the same on every machine; the fixed lag's past is not part of it.
    int numbers() const {
        return c->arena_size + c->count + c->carry_size + 2 * int(c->declared.propose.start.size()) + c->declared.memory_size() + 7 + 3 + 6 + 2 +
               (c->declared.hindsight ? 3 + 2 * c->doubt_size() : 0);
    }
    std::string save() const {
        std::vector<double> all(std::size_t(numbers()) * n);
        for (int k = 0; k < n; ++k) exchange(states[k / width<T>], k % width<T>, &all[std::size_t(k) * numbers()], false);
        return saved_state(fingerprint(c->declared), n, numbers(), all);
    }
    // Throws std::invalid_argument, and leaves the tracks as they are, where the bytes are not a state of this filter.
    void restore(const char *from, std::size_t size) {
        std::vector<double> saved = state_numbers(from, size, fingerprint(c->declared), n, numbers());
        std::vector<TrackState<T>> taken = states;
        for (int k = 0; k < n; ++k) exchange(taken[k / width<T>], k % width<T>, &saved[std::size_t(k) * numbers()], true);
        for (auto &s : taken) {
            check_numbers(s), check_places(s);
            s.settled = all(s.running);
        }
        states = std::move(taken);
    }

  protected:
    Step<T> step;
    Aid<T> aid;
    Smooth<T> back;
    int n, lag;
    std::vector<TrackState<T>> states;
    std::vector<std::deque<Record<T>>> history;
    Spare<T> spare;
    std::vector<std::deque<T>> times;

    // Of tracks that have started. A detector may remember that nothing was measured, and a state may have begun without a time.
    // Numbers above `most` are not finite once a scan has multiplied four of them: a variance, twice by what turns.
    void check_numbers(const TrackState<T> &s) const {
        constexpr double most = 1e75;
        const auto check = [&](auto from, auto to) {
            for (; from != to; ++from)
                for (int l = 0; l < width<T>; ++l)
                    if (lane(s.started, l) && !(std::fabs(lane(*from, l)) <= most))
                        throw std::invalid_argument("state: has numbers that are not finite, or above 1e75");
        };
        for (int l = 0; l < width<T>; ++l)
            if (lane(s.running, l) && !lane(s.started, l)) throw std::invalid_argument("state: runs before it has started");
        for (const auto *values : {&s.arena, &s.probability, &s.carry, &s.believed, &s.doubted}) check(values->begin(), values->end());
        // the innovations that an aid looks back on come last
        check(s.memory.end() - c->declared.aid.memory(c->declared.axes()), s.memory.end());
    }

    // Places of modes are used as indices; those of a grid lie between its points too.
    void check_places(const TrackState<T> &s) const {
        const bool grid = c->declared.propose.kind == Propose::grid;
        for (const auto *places : {&s.alive, &s.next})
            for (const T &place : *places)
                for (int l = 0; l < width<T>; ++l) {
                    const double at = lane(place, l);
                    if (!(at >= -1.0 && at < c->members() && (grid || at == std::floor(at)))) throw std::invalid_argument("state: names a mode that there is not");
                }
    }

    void delay(int pack, const Scan<T> &scan, T before, Snapshot<T> &out) {
        const TrackState<T> &s = states[pack];
        std::deque<Record<T>> &past = history[pack];
        if (times.size() != history.size()) times.resize(history.size());
        Record<T> r;
        r.number = past.empty() ? 0.0 : past.back().number + 1.0;
        record(step, s, scan, out.outcome, before, r, spare);
        for (int k = int(past.size()) - 1; k >= 0 && c->declared.hindsight; --k) decide(past[k], out.outcome, r.number);
        past.push_back(std::move(r)), times[pack].push_back(s.time);
        if (int(past.size()) > lag + 1) past.pop_front(), times[pack].pop_front();
        for (auto &each : past) recall(*c, each, splat<T>(past.back().number));
        back.last(past.back());
        for (int k = int(past.size()) - 2; k >= 0; --k) back.step(past[k], past[k + 1]);
        out.time = times[pack].front(), out.arena = back.arena, out.probability = back.probability;
        out.started = past.front().started;
    }

    template <class State> void exchange(State &s, int l, double *at, bool in) const {
        const auto number = [&](auto &value) {
            if constexpr (!std::is_const_v<State>) {
                if (in) set_lane(value, l, *at);
            }
            if (!in) *at = lane(value, l);
            ++at;
        };
        for (auto &value : s.arena) number(value);
        for (auto *values : {&s.probability, &s.carry, &s.alive, &s.next, &s.memory})
            for (auto &value : *values) number(value);
        number(s.time), number(s.last_accepted), number(s.last_height), number(s.rejections), number(s.surprise), number(s.surprise_dof), number(s.first_time);
        for (auto &value : s.first) number(value);
        for (auto &value : s.first_P) number(value);
        if (c->declared.hindsight) number(s.doubt), number(s.in_doubt), number(s.height_in_doubt);
        for (auto *values : {&s.believed, &s.doubted})
            for (auto &value : *values) number(value);
        const auto flag = [&](auto &mask) {
            if constexpr (!std::is_const_v<State>) {
                if (in) set_lane(mask, l, *at != 0.0);
            }
            if (!in) *at = lane(mask, l);
            ++at;
        };
        flag(s.started), flag(s.running);
    }
};

}  // namespace jink::inline JINK_LEVEL
