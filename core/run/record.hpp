// What the forward pass leaves behind of one scan for the smoothers.
#pragma once

#include "scan/step.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> struct Record {
    std::vector<T> arena, probability;
    T dt, input[3];
    Coasted<T> coasted;  // of the step to this scan
    bool has_input;
    Mask<T> started, linked, used;  // has a state; it follows from the scan before; its measurement was believed
    Measurement<T> measurement;     // of the lanes whose sensor is the first one
    std::vector<Measurement<T>> others;  // of the lanes of each further sensor, if lanes differ
    int sensor;
    std::vector<T> coefficients, inputs;  // of each mode in the step to this scan, where they vary

    const T *input_of(int j) const { return !inputs.empty() ? &inputs[j * 3] : has_input ? input : nullptr; }
};

template <class T>
void record(const Step<T> &step, const TrackState<T> &s, const Scan<T> &scan, const Outcome<T> &o, T before, Record<T> &r) {
    const Composition<T> &c = step.c;
    r.arena = s.arena, r.probability = s.probability;
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
    step.ahead.used(r.coefficients), r.inputs = step.ahead.inputs;
    if (c.count == 1) return;
    const auto lanes_of = [&](int sensor) {
        Mask<T> mine = splat_mask<T>(!scan.sensor);
        for (int l = 0; l < width<T> && scan.sensor; ++l) set_lane(mine, l, scan.sensor[l] == sensor);
        return mine & r.used;
    };
    step.measure(scan, c.sensors[r.sensor], lanes_of(r.sensor), r.measurement);
    for (int sensor = 1; sensor < int(c.sensors.size()) && scan.sensor; ++sensor) {
        r.others.emplace_back();
        step.measure(scan, c.sensors[sensor], lanes_of(sensor), r.others.back());
    }
}

}  // namespace jink::inline JINK_LEVEL
