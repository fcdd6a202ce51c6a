// What filters with models of the user's own need of the engine: they step scan by scan in Python over a batch of tracks, and
// mix, update and ask the library's own models here. One track at a time, sizes at run time, matrices row by row and whole.
#pragma once

#include "scan/predict.hpp"
#include "models/sensor.hpp"

namespace jink::inline JINK_LEVEL {

inline constexpr int largest_own = 16;  // components of a state, or of a measurement

// The mixture of estimates (as mix.hpp): x0 = sum_i w_i x_i, P0 = sum_i w_i (P_i + (x_i - x0)(x_i - x0)').
void mix_estimates(int modes, int n, const double *const *x, const double *const *P, const double *w, double *x0, double *P0);

// What an update says of its measurement; arrays of m and joint of m by m, as in Innovation.
struct OwnInnovation {
    double nis, det;
    double *e, *S, *joint;
};

// One component after the other, as in update.hpp: residual y and H (m by n) about the prediction, noise R (m by m). All of y, H
// and R are overwritten; x and P become the updated ones.
void update_own(int n, int m, const bool *present, double *y, double *H, double *R, double *x, double *P, OwnInnovation &v);

// P = L L'. `semidefinite`: a pivot lost in rounding leaves its column zero; otherwise pivots are at least `least`.
void root_of(int n, const double *P, bool semidefinite, double least, double *L);

// X <- L^-1 X, or L'^-1 X, for X of n by k.
void solve_own(int n, int k, const double *L, bool transposed, double *X);

}  // namespace jink::inline JINK_LEVEL
