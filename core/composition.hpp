// A filter as it was declared (Declaration), and the same made ready to run on one number type (Composition).
#pragma once

#include <string>
#include <vector>

#include "mix.hpp"
#include "predict.hpp"
#include "transition.hpp"
#include "update.hpp"

namespace jink::inline JINK_LEVEL {

struct ModeDeclaration {
    MotionSpec motion;
    StateShape shape;
    std::vector<double> parameters;       // as the motion's prepare() reads them
    std::vector<double> prior_variance;   // per component: where it starts, and where it enters from modes without it
};

struct SensorDeclaration {
    SensorSpec spec;
    bool converted;                    // a polar measurement is turned into a Cartesian one first
    std::vector<double> noise;         // variances, or the packed covariance if spec.correlated
    std::vector<double> log_extent;    // of the uniform outlier density, per component
};

enum class Start { two_point, one_point };

struct Declaration {
    std::vector<ModeDeclaration> modes;
    std::vector<SensorDeclaration> sensors;
    bool continuous = false;                  // transition is a generator
    std::vector<double> transition;           // modes x modes
    std::vector<double> mode_probability;     // initial
    bool unscented = false, unbiased_mixing = false;
    double outlier_share = 0.0;
    int restart_after = 0;                    // rejections in a row; 0 never
    double coast = 0.0;                       // seconds without an accepted measurement; 0 for ever
    Start start = Start::two_point;
    double velocity_variance = 0.0;           // of a track started from one point

    int axes() const { return modes[0].shape.axes; }
    int columns() const {
        int most = 1;
        for (const auto &s : sensors) most = std::max(most, s.spec.rows);
        return most;
    }
    bool has_acceleration() const {
        for (const auto &m : modes)
            if (m.shape.block == 3) return true;
        return false;
    }
    bool has_turn_rate() const {
        for (const auto &m : modes)
            if (m.shape.turn) return true;
        return false;
    }
    // The components an estimate is reported in: per axis p v (a), then the turn rate.
    StateShape reported() const {
        const int block = has_acceleration() ? 3 : 2;
        return {axes(), block, axes() * block + has_turn_rate(), has_turn_rate()};
    }
};

// Where component c of `of` stands in `in`, or -1. Both are interleaved per axis with the turn rate last.
inline int place_of(const StateShape &of, int c, const StateShape &in) {
    if (of.turn && c == of.n - 1) return in.turn ? in.n - 1 : -1;
    return c % of.block < in.block ? (c / of.block) * in.block + c % of.block : -1;
}

template <class T> struct Mode {
    MotionSpec motion;
    StateShape shape;
    MotionKernels<T> kernels;
    UpdateKernels<T> update;
    MixKernel<T> mix;
    std::vector<T> parameters, prior_variance;
    int place;                 // of its x in the arena; its packed P follows
    std::vector<int> sources;  // for each source mode: the places of x and P as this mode sees them
    int size() const { return shape.n + packed_size(shape.n); }
};

template <class T> struct Sensor {
    SensorSpec spec;
    bool converted;
    std::vector<T> noise;
    std::vector<double> log_extent;
};

template <class T> struct Composition {
    Declaration declared;
    std::vector<Mode<T>> modes;
    std::vector<Sensor<T>> sensors;
    Transition<T> transition;
    std::vector<T> initial_probability;
    StateShape reported;
    int arena_size = 0, count = 0;
    bool derived = false;  // some mode lacks a reported component

    explicit Composition(const Declaration &d) : declared(d), reported(d.reported()), count(int(d.modes.size())) {
        const auto numbers = [](const std::vector<double> &from) {
            std::vector<T> to;
            for (double value : from) to.push_back(splat<T>(value));
            return to;
        };
        arena_size = 1;  // place 0 holds a zero
        bool alike = true;  // all modes have the same components
        for (const auto &m : d.modes) alike = alike && m.shape.n == d.modes[0].shape.n;
        for (const auto &m : d.modes) {
            Mode<T> mode{m.motion, m.shape, motion_kernels<T>(m.motion, d.unscented), update_kernels<T>(m.shape),
                         alike ? mix_kernel<T, true>(m.shape.n) : mix_kernel<T, false>(m.shape.n), numbers(m.parameters), numbers(m.prior_variance), 0, {}};
            arena_size += m.shape.n;  // its prior variances
            derived = derived || m.shape.n != reported.n;
            modes.push_back(mode);
        }
        for (auto &m : modes) m.place = arena_size, arena_size += m.size();
        for (int j = 0, prior = 1; j < count; prior += modes[j].shape.n, ++j) lay_out_sources(j, prior);
        for (const auto &s : d.sensors) sensors.push_back({s.spec, s.converted, numbers(s.noise), s.log_extent});
        transition = Transition<T>(count, d.continuous, numbers(d.transition));
        initial_probability = numbers(d.mode_probability);
    }

    void lay_out_sources(int j, int prior) {
        Mode<T> &target = modes[j];
        const int n = target.shape.n;
        for (int i = 0; i < count; ++i) {
            const Mode<T> &source = modes[i];
            std::vector<int> at(n);
            for (int c = 0; c < n; ++c) at[c] = place_of(target.shape, c, source.shape);
            for (int c = 0; c < n; ++c)
                target.sources.push_back(at[c] >= 0 ? source.place + at[c] : declared.unbiased_mixing ? target.place + c : 0);
            for (int r = 0; r < n; ++r)
                for (int c = 0; c <= r; ++c) {
                    int place = 0;
                    if (at[r] >= 0 && at[c] >= 0) place = source.place + source.shape.n + packed(at[r], at[c]);
                    else if (declared.unbiased_mixing && at[r] < 0 && at[c] < 0) place = target.place + n + packed(r, c);
                    else if (r == c) place = prior + r;
                    target.sources.push_back(place);
                }
        }
    }
};

}  // namespace jink::inline JINK_LEVEL
