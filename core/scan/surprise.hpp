// How much larger a track's innovations are than its filter says. The gate asks it before it rejects a measurement.
#pragma once

#include "scan/track.hpp"

namespace jink::inline JINK_LEVEL {

// Of the mode that fits a measurement best: its NIS and the determinant of its innovation's covariance.
template <class T> struct BestFit {
    T nis, det;
};

// A target that keeps moving outside the models is no outlier at every scan. While the mean NIS per dimension of its last
// rows exceeds `largest_mean`, a measurement is judged by Student's t: a Gaussian whose scale the last rows tell,
//     t(v; ν, κS),   ν = Σ w dof,   κ = Σ w NIS / ν,   w = 1, forget, forget², … back from the last accepted row.
// Γ((ν + m) / 2) / Γ(ν / 2) is taken as (ν / 2)^(m / 2), exact in two dimensions. A measurement that is believed for this
// alone is used with predictions widened to the scale that it and the last rows tell.
struct Surprise {
    static constexpr double forget = 0.9;        // about ten rows are remembered
    static constexpr double largest_mean = 4.0;  // two consistent rows in two dimensions exceed it once in 300
    static constexpr double fewest = 1.5;        // rows
    static constexpr double most = 25.0;         // per dimension: what one row adds at most

    template <class T> static void add(TrackState<T> &s, const BestFit<T> &fit, T dof, Mask<T> accepted) {
        const T nis = smaller<T>(fit.nis, most * dof);
        s.surprise = select<T>(accepted, forget * s.surprise + nis, s.surprise);
        s.surprise_dof = select<T>(accepted, forget * s.surprise_dof + dof, s.surprise_dof);
    }

    // Where the track has not been moving as its models say, and so explains the measurement better than an outlier does.
    template <class T> static Mask<T> explains(const TrackState<T> &s, const BestFit<T> &fit, T dof, T log_target_share, T log_outlier) {
        constexpr double two_pi = 6.28318530717958647693;
        const T degrees = larger<T>(s.surprise_dof, splat<T>(1e-9)), scale = s.surprise * reciprocal(degrees);
        const Mask<T> known = (degrees > fewest * dof) & (scale > splat<T>(largest_mean));
        const T tail = 1.0 + fit.nis * reciprocal(larger<T>(s.surprise, splat<T>(1e-9)));
        const T log_t = -0.5 * (logarithm<T>(fit.det) + dof * logarithm<T>(two_pi * larger<T>(scale, splat<T>(1e-9))) + (degrees + dof) * logarithm<T>(tail));
        return known & (log_t + log_target_share > log_outlier);
    }

    template <class T> static T scale_with(const TrackState<T> &s, const BestFit<T> &fit, T dof) {
        return (s.surprise + fit.nis) * reciprocal(larger<T>(s.surprise_dof + dof, splat<T>(1e-9)));
    }
};

}  // namespace jink::inline JINK_LEVEL
