// What a track carries from scan to scan, what a scan brings, and what it leaves.
#pragma once

#include "scan/composition.hpp"

namespace jink::inline JINK_LEVEL {

enum class Status : unsigned char { none, updated, predicted, gated, restarted, initialised };

// Everything a track carries from scan to scan.
template <class T> struct TrackState {
    std::vector<T> arena;        // a zero, the priors, then each mode's x and packed P after its last update
    std::vector<T> probability;  // of each mode
    std::vector<T> carry;        // what modes adapt by, mode after mode
    std::vector<T> alive, next;  // of each slot: its place in the set of modes after the last scan and in the next one, or -1
    std::vector<T> memory;       // of a detector, as it lays it out
    T time, last_accepted, rejections;
    T last_height;               // time of the last accepted measurement of the third axis
    T surprise, surprise_dof;            // of the rows accepted last, see surprise.hpp
    T doubt;                             // that the last measurement is an outlier, where both are followed; else 0
    T in_doubt, height_in_doubt;         // time of that measurement, and of its third axis
    std::vector<T> believed, doubted;    // the banks with and without it, as hindsight.hpp lays them out
    T first[3], first_P[6], first_time;  // the first position, while waiting for a second
    Mask<T> started, running;    // has a state; its initialisation is complete
    bool settled;                // all lanes are running

    explicit TrackState(const Composition<T> &c) { reset(c); }

    void reset(const Composition<T> &c);
};

// One scan as it comes in. Lanes whose track has ended are not `active`.
template <class T> struct Scan {
    T time;
    Mask<T> active;
    T z[largest_measurement], R[packed_size(largest_measurement)];
    bool own_noise = false, own_full = false;  // R given with the row: variances, or packed covariance
    int one_sensor = 0;                        // of all lanes,
    const std::int32_t *sensor = nullptr;      // or of each, where they differ
    const T *input = nullptr;                  // known acceleration per axis
};

// What a scan says of itself, per lane.
template <class T> struct Outcome {
    T log_likelihood, dof, nis;
    T pit[largest_measurement];
    Mask<T> measured, scored, gated, restarted, initialised;  // scored: its likelihood, NIS and PIT count
    Mask<T> decided, upheld;  // the measurement before, which was in doubt: now decided; it is the target's
};

enum Detail { plain = 0, with_nis = 1, with_pit = 2, with_innovations = 4 };  // the last: y and its covariance, of each mode

template <class T> void TrackState<T>::reset(const Composition<T> &c) {
    const T zero = splat<T>(0.0);
    arena.assign(c.arena_size, zero);
    int prior = 1;
    for (const auto &m : c.modes) {
        for (int i = 0; i < m.shape.n; ++i) {
            arena[prior + i] = m.prior_variance[i];
            arena[m.place + m.shape.n + packed(i, i)] = splat<T>(1.0);
        }
        prior += m.shape.n;
    }
    probability = c.initial_probability;
    carry.assign(c.carry_size, zero);
    for (const auto &m : c.modes)
        if (m.adapt.remembers()) m.adapt.forget(m.shape.axes, m.declared.data(), &carry[m.carry], splat_mask<T>(true));
    alive = next = Composition<T>::numbers(c.declared.propose.start);
    memory.assign(c.declared.memory_size(), zero);
    believed.assign(c.doubt_size(), zero), doubted = believed;
    time = last_accepted = last_height = rejections = surprise = surprise_dof = doubt = in_doubt = height_in_doubt = first_time = zero;
    for (auto &value : first) value = zero;
    for (auto &value : first_P) value = zero;
    started = running = splat_mask<T>(false);
    settled = false;
}

}  // namespace jink::inline JINK_LEVEL
