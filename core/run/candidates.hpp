// One filter with many sets of numbers (see numbers.hpp) over the same tracks: what a search by populations needs.
#pragma once

#include "run/batch.hpp"

namespace jink::inline JINK_LEVEL {

// numbers (candidates, of the filter); truth (rows, 2 axes): positions, then velocities, NaN where unknown. sums (candidates, scans, 3):
// at each scan the squared errors of position and of velocity, summed over axes and tracks, and how many tracks count: those that
// ran before the scan and whose true position is known.
void run_candidates(const Declaration &declaration, const double *numbers, std::int64_t candidates, const BatchInput &in, const double *truth,
                    std::int64_t scans, double *sums, int threads);

}  // namespace jink::inline JINK_LEVEL
