// What the forward pass leaves behind of one scan for the smoothers.
#pragma once

#include "scan/step.hpp"

namespace jink::inline JINK_LEVEL {

// Of a scan after which a measurement was followed two ways (hindsight.hpp): both banks, and what a later scan decided.
template <class T> struct Followed {
    bool any = false;
    Mask<T> lanes, open;  // in doubt; not decided
    Mask<T> used, upheld;  // the measurement: believed at first; the target's after all
    T decided;             // number of the scan that decided
    std::vector<T> believed, doubted;     // arena and probabilities of both banks
    std::vector<Measurement<T>> offered;  // of each sensor: what there is to believe or not
};
template <class T> using Spare = std::vector<Followed<T>>;  // the memory of those that nobody asks for any more

template <class T> struct Record {
    std::vector<T> arena, probability;
    T dt, input[3];
    Coasted<T> coasted;  // of the step to this scan
    bool has_input;
    Mask<T> started, linked, used;  // has a state; it follows from the scan before; its measurement was believed
    Measurement<T> measurement;     // of the lanes whose sensor is the first one
    std::vector<Measurement<T>> others;  // of the lanes of each further sensor, if lanes differ
    int sensor;
    Followed<T> followed;
    double number = 0.0;  // of the scan
    std::vector<T> coefficients, inputs;  // of each mode in the step to this scan, where they vary

    const T *input_of(int j) const { return !inputs.empty() ? &inputs[j * 3] : has_input ? input : nullptr; }
};

// The record as it was known after the scan of a number, lane by lane; a later number than before, or the same.
template <class T> void recall(const Composition<T> &c, Record<T> &r, T until) {
    const Followed<T> &f = r.followed;
    if (!f.any) return;
    const Mask<T> known = f.lanes & inverse(f.open) & (f.decided <= until), believed = known & f.upheld;
    const auto choose = [&](int k, T out) { return select<T>(believed, f.believed[k], select<T>(known, f.doubted[k], out)); };
    if (any(known)) {
        for (int k = c.modes[0].place; k < c.arena_size; ++k) r.arena[k] = choose(k, r.arena[k]);
        for (int j = 0; j < c.count; ++j) r.probability[j] = choose(c.arena_size + j, r.probability[j]);
    }
    r.used = (f.used & inverse(known)) | believed;
    if (f.offered.empty()) return;
    for (std::size_t i = 0; i < f.offered.size(); ++i)
        for (int k = 0; k < largest_measurement; ++k)
            (i ? r.others[i - 1] : r.measurement).present[k] = f.offered[i].present[k] & (r.used | inverse(f.lanes));
}

// A later scan says whether the measurement in doubt was the target's; returns the lanes where this record waited for it.
template <class T> Mask<T> decide(Record<T> &r, const Outcome<T> &o, double scan) {
    Followed<T> &f = r.followed;
    const Mask<T> now = f.any ? f.open & o.decided : splat_mask<T>(false);
    if (!any(now)) return now;
    f.open = f.open & inverse(now), f.upheld = (f.upheld & inverse(now)) | (now & o.upheld);
    f.decided = select<T>(now, splat<T>(scan), f.decided);
    return now;
}

// All has been decided: the record is what it will be.
template <class T> void close(Record<T> &r, Spare<T> &spare) {
    if (any(r.followed.open)) return;
    spare.push_back(std::move(r.followed));
    r.followed.any = false;
}

template <class T> void follow(const Composition<T> &c, const TrackState<T> &s, const Scan<T> &scan, Record<T> &r, Spare<T> &spare) {
    Followed<T> &f = r.followed;
    f.any = false;
    if (!c.declared.hindsight) return;
    const Mask<T> doubtful = scan.active & (s.doubt > splat<T>(0.0));
    if (!any(doubtful)) return;
    if (f.believed.empty() && !spare.empty()) f = std::move(spare.back()), spare.pop_back();
    f.any = true, f.lanes = f.open = doubtful;
    f.used = r.used, f.upheld = splat_mask<T>(false), f.decided = splat<T>(0.0);
    f.believed = s.believed, f.doubted = s.doubted;
    f.offered.clear();
}

template <class T>
void record(const Step<T> &step, const TrackState<T> &s, const Scan<T> &scan, const Outcome<T> &o, T before, Record<T> &r, Spare<T> &spare) {
    const Composition<T> &c = step.c;
    if (r.arena.size() == s.arena.size()) std::copy(s.arena.begin() + c.modes[0].place, s.arena.end(), r.arena.begin() + c.modes[0].place);
    else r.arena = s.arena;  // what lies before the modes never changes
    r.probability = s.probability;
    r.dt = s.time - before;
    r.coasted = step.ahead.coasted;
    r.has_input = scan.input != nullptr;
    for (int a = 0; a < c.declared.axes() && r.has_input; ++a) r.input[a] = scan.input[a];
    r.started = s.started;
    // a start has no past, but the second point of a two-point start has
    const Mask<T> begun = (o.initialised & (s.first_time == s.time)) | o.restarted;
    r.linked = scan.active & s.started & inverse(begun);
    r.used = scan.active & inverse(o.gated);
    r.sensor = scan.sensor ? 0 : scan.one_sensor;
    r.others.clear();
    follow(c, s, scan, r, spare);
    step.ahead.used(r.coefficients), r.inputs = step.ahead.inputs;
    if (c.count == 1) return;
    const auto lanes_of = [&](int sensor) {
        Mask<T> mine = splat_mask<T>(!scan.sensor);
        for (int l = 0; l < width<T> && scan.sensor; ++l) set_lane(mine, l, scan.sensor[l] == sensor);
        return mine & (r.followed.any ? r.used | r.followed.lanes : r.used);
    };
    step.measure(scan, c.sensors[r.sensor], lanes_of(r.sensor), r.measurement);
    for (int sensor = 1; sensor < int(c.sensors.size()) && scan.sensor; ++sensor) {
        r.others.emplace_back();
        step.measure(scan, c.sensors[sensor], lanes_of(sensor), r.others.back());
    }
    if (!r.followed.any) return;
    r.followed.offered = r.others;
    r.followed.offered.insert(r.followed.offered.begin(), r.measurement);
    recall(c, r, splat<T>(r.number));
}

}  // namespace jink::inline JINK_LEVEL
