// Many tracks of any length, packed lane by lane, over threads.
#pragma once

#include "instances/instances.hpp"

namespace jink::inline JINK_LEVEL {

// Element (row, column) of the noise of measurements, of all rows; the same in (column, row).
struct NoiseColumn {
    int row, column;
    const double *values;
};

// Flat arrays of all tracks' rows; track b owns rows offsets[b] .. offsets[b+1]. Null where not given.
struct BatchInput {
    const double *time, *z;
    int columns;
    const std::int64_t *offsets;
    std::int64_t tracks;
    const std::int32_t *sensor = nullptr;
    const double *noise = nullptr;   // per row: columns variances, or columns x columns
    std::vector<NoiseColumn> noise_columns;  // instead: what is not zero in it
    bool full_noise = false;
    const double *input = nullptr;   // per row: axes
    const double *prior_x = nullptr, *prior_P = nullptr;  // per track, in the reported components
    const std::int64_t *until = nullptr;  // smoothing with a lag: per row, the last row of its track that it uses
};

// Element (row, column) of P, of all rows: an array of its own.
struct Covariance {
    int row, column;
    double *to;
};

// Where results go; null where not wanted.
struct BatchOutput {
    double *x = nullptr, *P = nullptr, *mode_probability = nullptr;
    double *log_likelihood = nullptr;       // per track
    double *log_likelihood_scan = nullptr, *nis = nullptr, *nis_dof = nullptr, *pit = nullptr;
    unsigned char *status = nullptr;
    std::vector<Covariance> covariances;
};

void run_batch(const Composition<Pack> &composition, const BatchInput &in, const BatchOutput &out, bool smooth, int threads);

// A given prior: mean and covariance in the reported components, for one lane.
template <class T> void set_prior(const Composition<T> &c, TrackState<T> &s, int lane_of, const double *x, const double *P, double time) {
    const int n = c.reported.n;
    for (const auto &mode : c.modes)
        for (int r = 0; r < mode.shape.n; ++r) {
            const int at_r = place_of(mode.shape, r, c.reported);  // -1: only the side estimator has it
            set_lane(s.arena[mode.place + r], lane_of, at_r < 0 ? 0.0 : x[at_r]);
            for (int k = 0; k <= r; ++k) {
                const int at_k = place_of(mode.shape, k, c.reported);
                const double known = at_r < 0 || at_k < 0 ? (r == k ? lane(mode.prior_variance[r], 0) : 0.0) : P[at_r * n + at_k];
                set_lane(s.arena[mode.place + mode.shape.n + packed(r, k)], lane_of, known);
            }
        }
    set_lane(s.started, lane_of, true);
    set_lane(s.running, lane_of, true);
    set_lane(s.time, lane_of, time);
    set_lane(s.doubt, lane_of, 0.0);
    set_lane(s.last_accepted, lane_of, time), set_lane(s.last_height, lane_of, time);
    for (auto &value : s.memory) set_lane(value, lane_of, 0.0);
    if (c.declared.aid.kind != AidInputs::plane) return;
    T *past = s.memory.data() + s.memory.size() - c.declared.aid.memory(c.reported.axes);
    for (int k = 0; k < plane_memory; ++k) set_lane(past[k], lane_of, k == plane_time && !std::isnan(time) ? time : plane_begins(k));
}

// The same for the lanes of a pack, from the batch's priors.
template <class T>
void begin_at_prior(const Composition<T> &c, const BatchInput &in, TrackState<T> &s, const std::int64_t *tracks, int used) {
    const int n = c.reported.n;
    for (int l = 0; l < used; ++l) {
        const std::int64_t b = tracks[l], first = in.offsets[b];
        if (in.offsets[b + 1] > first) set_prior(c, s, l, in.prior_x + b * n, in.prior_P + b * n * n, in.time[first]);
    }
    s.settled = all(s.running);
}

// The status of a lane after a scan.
template <class T> Status status_of(const TrackState<T> &s, const Outcome<T> &o, int l) {
    if (!lane(s.started, l)) return Status::none;
    if (lane(o.initialised, l)) return lane(o.restarted, l) ? Status::restarted : Status::initialised;
    if (lane(o.gated, l)) return Status::gated;
    return lane(o.measured, l) ? Status::updated : Status::predicted;
}

}  // namespace jink::inline JINK_LEVEL
