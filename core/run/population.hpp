// Many fuzzy filters over the same runs: what identification by a population of candidates needs.
#pragma once

#include "models/fuzzy.hpp"

namespace jink::inline JINK_LEVEL {

inline constexpr int largest_population_modes = 5;

// One axis, states [p v], modes whose process noise variance comes from rules over the residual and its change.
struct PopulationInput {
    std::int64_t individuals, modes, rules;  // rules: room for so many in each table
    const double *tables;                    // (individuals, modes, rules, 5): c1, s1, c2, s2, w
    const std::int64_t *count;               // (individuals, modes) rules in use
    const double *transition, *probability;  // (individuals, modes, modes), (individuals, modes)
    std::int64_t runs, scans;
    const double *time, *z, *position, *velocity;  // (runs, scans); NaN where missed or unknown
    double variance;                               // of the measurement
};

// errors (individuals, scans, 2): squared errors of position and velocity, summed over the runs that have started before the scan.
void population_errors(const PopulationInput &in, double *errors, int threads);

}  // namespace jink::inline JINK_LEVEL
