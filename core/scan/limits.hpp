// What the engine has room for. A declaration beyond it is refused before anything is made of it.
#pragma once

#include <stdexcept>
#include <string>

#include "models/network.hpp"
#include "scan/plane_corrector.hpp"

namespace jink::inline JINK_LEVEL {

inline constexpr int largest_set = 512;  // modes

inline void check_layers(const std::vector<int> &sizes, const char *what) {
    for (const int size : sizes)
        if (size < 1 || size > largest_layer)
            throw std::invalid_argument(std::string(what) + ": expected layers of 1 to " + std::to_string(largest_layer) + ", got one of " + std::to_string(size));
}

// A correction in the plane: of the modes that there are, and with as many numbers as its layers take.
inline void check_plane(const Declaration &d) {
    const int modes = int(d.modes.size()), even = plane_even(modes);
    if (d.axes() < 2 || !d.has_acceleration() || d.propose.kind != Propose::all)
        throw std::invalid_argument("aid: a correction in the plane needs two axes, a mode that accelerates and a fixed set of modes");
    if (d.aid.sizes.empty() || d.aid.sizes.size() > 2 || d.aid.kept() > plane_kept)
        throw std::invalid_argument("aid: expected units and at most " + std::to_string(plane_kept) + " quantities that they remember");
    if (d.aid.inputs != even)
        throw std::invalid_argument("aid: expected " + std::to_string(even) + " inputs for " + std::to_string(modes) + " modes, got " + std::to_string(d.aid.inputs));
    if (int(d.aid.numbers.size()) != plane_numbers(even, d.aid.sizes[0], d.aid.kept())) throw std::invalid_argument("aid: has another number of weights than its layers take");
}

inline void check_limits(const Declaration &d) {
    if (d.modes.empty()) throw std::invalid_argument("motions: expected at least one");
    if (int(d.modes.size()) > largest_set)
        throw std::invalid_argument("motions: expected at most " + std::to_string(largest_set) + ", got " + std::to_string(d.modes.size()));
    for (const auto *modes : {&d.modes, &d.side})
        for (const auto &mode : *modes) check_layers(mode.adapt.sizes, "network");
    check_layers(d.scores.sizes, "network");
    check_layers(d.aid.sizes, "aid");
    if (d.aid.inputs > largest_layer || d.aid.outputs > largest_layer) throw std::invalid_argument("aid: has too many inputs or outputs");
    if (d.aid.kind == AidInputs::sums && (d.aid.inputs < 1 || d.aid.inputs > 7)) throw std::invalid_argument("aid: expected 1 to 7 sums");
    if (d.aid.kind == AidInputs::plane) check_plane(d);
    bool adapts = !d.side.empty() || d.propose.kind != Propose::all || d.detect.window || d.scores.kind != Adapt::none || d.interaction == Interaction::gpb2;
    for (const auto &mode : d.modes) adapts = adapts || mode.adapt.kind != Adapt::none;
    if (d.hindsight && (adapts || d.outlier_share <= 0.0))
        throw std::invalid_argument("outliers: expected hindsight=False; this filter does not follow a measurement in doubt two ways");
    for (const double mode : d.propose.start)
        if (!(mode >= -1.0 && mode < double(d.modes.size()))) throw std::invalid_argument("active: names a mode that there is not");
}

}  // namespace jink::inline JINK_LEVEL
