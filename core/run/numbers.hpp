// The numbers a filter can be differentiated by, in the one order they have everywhere.
#pragma once

#include "scan/composition.hpp"

namespace jink::inline JINK_LEVEL {

// Calls visit(number) for each, a reference into the declaration. A new kind of number is a line here (and is lifted where the
// Composition takes it up), and the gradient knows it.
template <class Visit> void each_number(const Declaration &declaration, Visit visit) {
    const auto all = [&](const std::vector<double> &numbers) {
        for (const double &number : numbers) visit(number);
    };
    for (const auto *modes : {&declaration.modes, &declaration.side})
        for (const auto &mode : *modes) all(mode.parameters), all(mode.prior_variance), all(mode.level), all(mode.adapt.numbers);
    for (const auto &sensor : declaration.sensors) all(sensor.noise);
    all(declaration.transition), all(declaration.initial_probability);
    visit(declaration.outlier_share), visit(declaration.velocity_variance);
}

inline std::vector<double> numbers_of(const Declaration &declaration) {
    std::vector<double> numbers;
    each_number(declaration, [&](const double &number) { numbers.push_back(number); });
    return numbers;
}

// Filters that choose among modes, watch for onsets, are weighed or aided by networks step where nothing is smooth (or not lifted).
inline bool differentiable(const Declaration &d) {
    return d.propose.kind == Propose::all && !d.detect.window && d.scores.kind == Adapt::none && d.aid.kind == AidInputs::none;
}

}  // namespace jink::inline JINK_LEVEL
