// One number for all that a filter was declared with: filters that differ in anything have different ones.
#pragma once

#include "run/saved_state.hpp"
#include "scan/composition.hpp"

namespace jink::inline JINK_LEVEL {

inline void digest(Digest &to, const AdaptDeclaration &d) {
    to.number(int(d.kind)), to.numbers(d.sizes), to.number(int(d.logarithmic)), to.numbers(d.numbers);
}

inline void digest(Digest &to, const ModeDeclaration &d) {
    for (const int value : {int(d.motion.kind), int(d.motion.noise), int(d.motion.turn_noise), d.motion.axes, d.shape.n, int(d.around_side) + 2 * int(d.in_sd)}) to.number(value);
    to.numbers(d.parameters), to.numbers(d.prior_variance), to.numbers(d.level);
    digest(to, d.adapt);
}

inline void digest(Digest &to, const SensorDeclaration &d) {
    const SensorSpec &s = d.spec;
    for (const int value : {int(s.kind), s.axes, s.rows, int(s.vertical), int(s.range_rate), int(s.from_north), int(s.correlated), int(d.converted)}) to.number(value);
    for (const double value : s.site) to.number(value);
    to.number(s.radius);
    to.numbers(d.noise), to.numbers(d.log_extent);
}

inline std::uint64_t fingerprint(const Declaration &d) {
    Digest to;
    for (const auto &mode : d.modes) digest(to, mode);
    for (const auto &mode : d.side) digest(to, mode);
    for (const auto &sensor : d.sensors) digest(to, sensor);
    to.numbers(d.transition), to.numbers(d.initial_probability);
    for (const int value : {int(d.continuous), int(d.unscented), int(d.unbiased_mixing), d.restart_after, int(d.start), int(d.interaction)}) to.number(value);
    for (const double value : {d.outlier_share, d.coast, d.velocity_variance}) to.number(value);
    for (const double value : {d.coasting.after, d.coasting.manoeuvre, d.coasting.climb}) to.number(value);
    to.number(int(d.coasting.reverses) + 2 * int(d.hindsight));
    to.number(int(d.propose.kind)), to.number(d.propose.slots), to.numbers(d.propose.start), to.numbers(d.propose.numbers);
    for (const auto &neighbours : d.propose.neighbours) to.numbers(neighbours);
    digest(to, d.scores);
    to.number(d.detect.window), to.number(d.detect.shortest), to.number(d.detect.threshold);
    to.number(int(d.aid.kind)), to.number(int(d.aid.model)), to.number(d.aid.inputs), to.numbers(d.aid.sizes), to.numbers(d.aid.numbers);
    return to.value();
}

}  // namespace jink::inline JINK_LEVEL
