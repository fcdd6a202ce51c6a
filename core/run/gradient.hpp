// Figures of a filter on many tracks, and their exact derivatives by its numbers (see numbers.hpp).
#pragma once

#include "run/batch.hpp"
#include "number/dual.hpp"

namespace jink::inline JINK_LEVEL {

inline constexpr int slopes_at_once = 5;
using Slopes = Dual<Pack, slopes_at_once>;

extern template MotionKernels<Slopes> motion_kernels<Slopes>(const MotionSpec &, bool);
extern template UpdateKernels<Slopes> update_kernels<Slopes>(const StateShape &);
JINK_STEP(extern, Slopes)

enum class Figure {
    log_likelihood,    // one sum: w log p(z)
    prediction_error,  // per measured component: w (z - h(x predicted `ahead` scans before))^2
    tracking_error     // per chosen reported component: w (x - target)^2
};

struct Objective {
    Figure figure;
    int ahead = 1;
    std::vector<int> components;     // of tracking_error, among the reported ones
    const double *target = nullptr;  // (rows, components)
    const double *weight = nullptr;  // (rows, sums); 1 where null
    int sums(int columns) const {
        return figure == Figure::log_likelihood ? 1 : figure == Figure::prediction_error ? columns : int(components.size());
    }
};

// `tangents` (directions, numbers) are the directions in the space of numbers; `value` (tracks, sums) and
// `slope` (directions, tracks, sums) are the sums of the objective and their derivatives.
void run_gradient(const Declaration &declaration, const BatchInput &in, const Objective &objective, const double *tangents, int directions,
                  double *value, double *slope, int threads);

}  // namespace jink::inline JINK_LEVEL
