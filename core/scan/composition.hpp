// A filter as it was declared (Declaration), and the same made ready to run on one number type (Composition).
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "scan/adapt.hpp"
#include "scan/mix.hpp"
#include "scan/predict.hpp"
#include "scan/transition.hpp"
#include "scan/update.hpp"

namespace jink::inline JINK_LEVEL {

struct ModeDeclaration {
    MotionSpec motion;
    StateShape shape;
    std::vector<double> parameters;       // as the motion's prepare() reads them
    std::vector<double> prior_variance;   // per component: where it starts, and where it enters from modes without it
    AdaptDeclaration adapt;
    std::vector<double> level;            // known acceleration of each axis in this mode, or empty
    bool around_side = false;             // the level counts from the side estimator's acceleration
    bool in_sd = false;                   // and in units of that estimator's standard deviation
};

struct SensorDeclaration {
    SensorSpec spec;
    bool converted;                    // a polar measurement is turned into a Cartesian one first
    std::vector<double> noise;         // variances, or the packed covariance if spec.correlated
    std::vector<double> log_extent;    // of the uniform outlier density, per component
};

enum class Start { two_point, one_point, bounded_two_point };

// How the modes' past estimates interact: each mode from its own mixture; not at all; all from the combined estimate; every pair
// of modes before and now apart.
enum class Interaction { imm, none, gpb1, gpb2 };

// Which modes are alive in a scan, of a set too large to run whole (propose.hpp).
enum class Propose { all, digraph, active, grid, dimension };

struct ProposeDeclaration {
    Propose kind = Propose::all;
    int slots = 0;                             // how many may be alive at once
    std::vector<double> start;                 // which modes a track starts with, one number per slot, -1 for none
    std::vector<std::vector<int>> neighbours;  // of each mode, itself included
    std::vector<double> numbers;               // as the kind reads them
};

// Input estimation beside one mode (input_estimation.hpp): window 0 for none.
struct DetectDeclaration {
    int window = 0, shortest = 1;  // scans: onsets watched, and how long one is watched before it may be taken
    double threshold = 0.0;
};

// A learned correction of what goes out (aid.hpp).
enum class AidInputs { none, residuals, innovations, sums, plane };
enum class AidModel { network, triangular, gaussian, bell };

inline constexpr int aid_factors = 3;    // of the sds of position, velocity, acceleration
inline constexpr int plane_memory = 13;  // numbers that a correction in the plane keeps of a track beside what its network remembers
// What these begin with, but for the time of the last scan that was taken.
constexpr double plane_begins(int k) { return k == 4 ? 1.0 : k == 5 ? 0.7 : 0.0; }
inline constexpr int plane_time = 10;

struct AidDeclaration {
    AidInputs kind = AidInputs::none;
    AidModel model = AidModel::network;
    int inputs = 0, outputs = 0;
    std::vector<int> sizes;       // of the network's layers, or membership functions per input; in the plane: units, and what they remember
    std::vector<double> numbers;  // as Aid reads them
    // Innovations that are looked back on: input k of sums takes 2^k of them.
    int history() const { return kind == AidInputs::innovations ? inputs : kind == AidInputs::sums ? 1 << (inputs - 1) : 0; }
    int kept() const { return sizes.size() > 1 ? sizes[1] : 0; }  // in the plane
    int memory(int axes) const { return kind == AidInputs::plane ? plane_memory + 2 * kept() : history() * axes; }
};

// What a target does while nothing is measured (coasting.hpp). Times in seconds; after 0: it goes on as it was.
struct CoastDeclaration {
    double after = 0.0, manoeuvre = 1.0, climb = 1.0;
    bool reverses = true;
    bool active() const { return after > 0.0 || !reverses; }
};

struct Declaration {
    std::vector<ModeDeclaration> modes;
    std::vector<SensorDeclaration> sensors;
    bool continuous = false;                  // transition is a generator
    std::vector<double> transition;           // modes x modes
    std::vector<double> initial_probability;  // of each mode
    bool unscented = false, unbiased_mixing = false;
    double outlier_share = 0.0;
    int restart_after = 0;                    // rejections in a row; 0 never
    bool hindsight = false;                   // a measurement in doubt is decided by the next one (hindsight.hpp)
    double coast = 0.0;                       // seconds without an accepted measurement; 0 for ever
    CoastDeclaration coasting;
    Start start = Start::two_point;
    double velocity_variance = 0.0;           // of a track started from one point
    Interaction interaction = Interaction::imm;
    std::vector<ModeDeclaration> side;        // at most one: an estimator of the acceleration beside the modes
    ProposeDeclaration propose;               // over all of `modes`; mode_probability is then that of the slots
    AdaptDeclaration scores;                  // a network that weighs the modes instead of Bayes' rule, or none
    DetectDeclaration detect;
    AidDeclaration aid;

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
    // What detectors remember: one scan of the variable-dimension filter, one onset of input estimation, and all of it.
    int history_entry() const { return 2 + axes() + packed_size(axes()) + modes[0].shape.n + packed_size(modes[0].shape.n); }
    int onset_entry() const { return 1 + modes[0].shape.n * axes() + packed_size(axes()) + axes(); }
    int memory_size() const {
        const int window = propose.kind == Propose::dimension ? int(propose.numbers[0]) : 0;
        return (window ? 3 + window + (window + 2) * history_entry() : 0) + detect.window * onset_entry() + aid.memory(axes());
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
    bool alike;                // all modes have its components
    std::vector<T> parameters, prior_variance;
    int place;                 // of its x in the arena; its packed P follows
    std::vector<int> sources;  // for each source mode: the places of x and P as this mode sees them
    Adaptation<T> adapt;
    std::vector<T> unit;       // parameters for unit variance on each axis and no other noise, if it adapts
    std::vector<T> declared;   // the variances it was declared with, if it adapts: `parameters` then has zeros
    std::vector<T> level;
    bool around_side = false, in_sd = false;
    int carry = 0;             // place of what it adapts by in the track's carry
    int size() const { return shape.n + packed_size(shape.n); }
    bool driven() const { return around_side || !level.empty(); }
};

template <class T> struct Sensor {
    SensorSpec spec;
    bool converted;
    std::vector<T> noise;
    std::vector<double> log_extent;
};

template <class T> struct Composition {
    // What a number of a declaration is here; numbers with derivatives know by the address which one it is (numbers.hpp).
    using Lift = std::function<T(const double &)>;

    Declaration declared;
    Lift lift;
    std::vector<Mode<T>> modes;  // those that run side by side, then the side estimator, if any
    std::vector<Sensor<T>> sensors;
    Transition<T> switching;
    std::vector<T> initial_probability;
    T outlier_share, velocity_variance, log_target_share, log_outlier_share;
    StateShape reported;
    int arena_size = 0, carry_size = 0, count = 0;
    bool derived = false;   // some mode lacks a reported component
    bool residuals = false;  // some mode adapts to the residual of the measured position
    bool varying = false;   // some mode's noise or input is not the same in every scan

    explicit Composition(const Declaration &d, Lift lift_ = splat<T>);

    static std::vector<T> numbers(const std::vector<double> &from) {
        std::vector<T> to;
        for (double value : from) to.push_back(splat<T>(value));
        return to;
    }
    std::vector<T> lifted(const std::vector<double> &from) const {
        std::vector<T> to;
        for (const double &value : from) to.push_back(lift(value));
        return to;
    }
    bool proposes() const { return declared.propose.kind != Propose::all; }
    const Mode<T> *side() const { return declared.side.empty() ? nullptr : &modes.back(); }
    int doubt_size() const { return declared.hindsight ? arena_size + count : 0; }  // of a bank that is kept aside
    int members() const { return int(declared.modes.size()); }  // of the whole set, of which `count` run

    void add_mode(const ModeDeclaration &m, bool alike) {
        Mode<T> mode{m.motion, m.shape, motion_kernels<T>(m.motion, declared.unscented), update_kernels<T>(m.shape),
                     alike ? mix_kernel<T, true>(m.shape.n) : mix_kernel<T, false>(m.shape.n), alike, lifted(m.parameters), lifted(m.prior_variance), 0, {},
                     Adaptation<T>(m.adapt, lifted(m.adapt.numbers)), {}, {}, lifted(m.level), m.around_side, m.in_sd, carry_size};
        if (mode.adapt.active()) {
            const MotionKind kind = m.motion.kind;
            const bool other_noise = kind == MotionKind::coordinated_turn || kind == MotionKind::augmented || kind == MotionKind::two_stage;
            mode.unit = mode.declared = mode.parameters;
            for (int k = 0; k < int(mode.parameters.size()); ++k) {
                if (k < m.shape.axes) mode.unit[k] = splat<T>(1.0), mode.parameters[k] = splat<T>(0.0);
                else if (other_noise) mode.unit[k] = splat<T>(0.0);
            }
        }
        carry_size += mode.adapt.carry_size(m.shape.axes);
        residuals = residuals || mode.adapt.needs_residual();
        varying = varying || mode.adapt.active() || mode.driven();
        arena_size += m.shape.n;  // its prior variances
        derived = derived || (int(modes.size()) < count && m.shape.n != reported.n);
        modes.push_back(mode);
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

template <class T>
Composition<T>::Composition(const Declaration &d, Lift lift_)
    : declared(d), lift(std::move(lift_)), reported(d.reported()), count(int(d.modes.size())) {
    if (proposes()) count = d.propose.slots;
    if (count < 1 || count > int(d.modes.size())) throw std::invalid_argument("propose: expected at least one slot, and no more than modes");
    arena_size = 1;  // place 0 holds a zero
    bool alike = true;  // all modes have the same components
    for (const auto &m : d.modes) alike = alike && m.shape.n == d.modes[0].shape.n;
    for (int j = 0; j < count; ++j) add_mode(d.modes[j], alike);
    for (const auto &m : d.side) add_mode(m, true);
    for (auto &m : modes) m.place = arena_size, arena_size += m.size();
    for (int j = 0, prior = 1; j < count; prior += modes[j].shape.n, ++j) lay_out_sources(j, prior);
    for (const auto &s : d.sensors) sensors.push_back({s.spec, s.converted, lifted(s.noise), s.log_extent});
    outlier_share = lift(d.outlier_share), velocity_variance = lift(d.velocity_variance);
    log_target_share = logarithm<T>(1.0 - outlier_share), log_outlier_share = logarithm<T>(outlier_share);
    if (!proposes()) switching = Transition<T>(count, d.continuous, lifted(d.transition));
    initial_probability = lifted(d.initial_probability);
}

}  // namespace jink::inline JINK_LEVEL
