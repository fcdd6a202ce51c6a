// A learned correction of position and velocity in the plane, along and across the estimated course; aid.hpp puts it on the output.
//
// Even inputs stay as they are when the plane is mirrored along the course, odd ones change sign; plane_network.hpp answers a mirrored target by
// the mirror image. Inputs and memory are in double precision, the network and the ranges of its inputs in single.
// The share of it that goes out is f g. f falls from 1 to 0 as inputs leave the range of the training. g is what the innovations say of the
// earlier corrections of the same track: with d = c_p + dt c_v, what a correction said of the next innovation y, in its sd,
// g = (k + sum y.d) / (k + sum d.d), within 0 and 1, both sums fading. It is the ridge regression of y on d, drawn towards 1.
// Until the next scan that is taken, what goes out is g d in position and g c_v in velocity.
#pragma once

#include "scan/composition.hpp"
#include "scan/plane_network.hpp"

namespace jink::inline JINK_LEVEL {

inline constexpr int plane_odd = 6;
// How fast what is remembered fades, per accepted scan.
inline constexpr double plane_fast = 0.6, plane_slow = 0.85, plane_average = 0.04, plane_most = 10.0, plane_fastest = 6.0;

constexpr int plane_even(int modes) { return 12 + 2 * (modes - 1); }
// low, high, centre, scale of each even input and of each odd one; fade, k, forgetting; the network's weights.
constexpr int plane_ranges(int even) { return 4 * (even + plane_odd) + 3; }
constexpr int plane_numbers(int even, int hidden, int kept) { return plane_ranges(even) + plane_weights(even, plane_odd, hidden, kept); }

// Mean (x, y) and covariance (xx, xy, yy) over the modes of what they say of the plane's positions (0) or velocities (1).
template <class T> struct PlaneMoments {
    T mean[2], P[3];

    PlaneMoments(const Composition<T> &c, const T *arena, const T *probability, int quantity) {
        for (int k = 0; k < 2; ++k) mean[k] = splat<T>(0.0);
        for (int k = 0; k < 3; ++k) P[k] = splat<T>(0.0);
        const auto place = [&](const Mode<T> &mode, int axis) { return axis * mode.shape.block + quantity; };
        for (int j = 0; j < c.count; ++j)
            for (int k = 0; k < 2; ++k) mean[k] = mean[k] + probability[j] * arena[c.modes[j].place + place(c.modes[j], k)];
        for (int j = 0; j < c.count; ++j) {
            const Mode<T> &mode = c.modes[j];
            const T *x = arena + mode.place, *own = x + mode.shape.n;
            const int p = place(mode, 0), q = place(mode, 1);
            const T dx = x[p] - mean[0], dy = x[q] - mean[1];
            P[0] = P[0] + probability[j] * (own[packed(p, p)] + dx * dx);
            P[1] = P[1] + probability[j] * (own[packed(q, p)] + dx * dy);
            P[2] = P[2] + probability[j] * (own[packed(q, q)] + dy * dy);
        }
    }
};

// What a scan left: the combined prediction and estimate, the modes' probabilities after and before it.
template <class T> struct Seen {
    PlaneMoments<T> before, position, velocity;
    const T *after, *probability, *prior;
    T time;
    const Fix<T> *fix;
    Mask<T> taken, begun;
};

template <class T> class PlaneCorrector {
  public:
    using S = Single<T>;

    PlaneCorrector() = default;
    PlaneCorrector(const AidDeclaration &declared, const StateShape &reported)
        : shape(reported), even(declared.inputs), kept(declared.kept()), network(even, plane_odd, declared.sizes[0], kept, &declared.numbers[plane_ranges(even)]) {
        const double *r = declared.numbers.data();
        for (int k = 0; k < even + plane_odd; ++k, r += 4)
            for (const double value : {r[0], r[1], 1.0 / (r[1] - r[0]), r[2], 1.0 / r[3]}) ranges.push_back(float(value));
        over_fade = float(1.0 / r[0]), trust = r[1], forget = r[2];
    }

    // Into `out`: what is added to each reported component, then the factors of their sds.
    void operator()(const Seen<T> &o, T *memory, T *out) const {
        T u[largest_layer], w[plane_odd], y[plane_answers];
        begin(o, memory);
        const View v(o, memory);
        remember(o, v, memory);
        inputs(o, v, memory, u, w);
        const T f = answer(o, u, w, memory + plane_memory, y);
        const T c[4] = {f * y[0] * v.sd[0], f * y[1] * v.sd[1], f * y[2] * v.sd[2], f * y[3] * v.sd[3]};
        const T now[4] = {c[0] * v.e[0] - c[1] * v.e[1], c[0] * v.e[1] + c[1] * v.e[0], c[2] * v.e[0] - c[3] * v.e[1], c[2] * v.e[1] + c[3] * v.e[0]};
        for (int k = 0; k < 4; ++k) memory[6 + k] = select<T>(o.taken, now[k], memory[6 + k]);
        carried(memory, o.time, out);
        const T factor = exponential<T>(f * proved(memory) * larger<T>(smaller<T>(y[4], splat<T>(0.7)), splat<T>(-0.7)));
        for (int i : {0, 1, shape.block, shape.block + 1}) out[shape.n + i] = select<T>(o.taken, factor, splat<T>(1.0));
    }

    // Of the last scan that was taken, as it moves on with the target.
    void carried(const T *memory, T time, T *out) const {
        const T g = proved(memory), dt = time - memory[plane_time], *said = memory + 6;
        for (int i = 0; i < shape.n; ++i) out[i] = splat<T>(0.0), out[shape.n + i] = splat<T>(1.0);
        for (int k = 0; k < 2; ++k) out[k * shape.block] = g * (said[k] + dt * said[2 + k]), out[k * shape.block + 1] = g * said[2 + k];
    }

  private:
    StateShape shape{};
    int even = 0, kept = 0;
    PlaneNetwork<T> network;
    std::vector<float> ranges;  // low, high, 1 / width, centre, 1 / scale of each input
    float over_fade = 0.0f;
    double trust = 0.0, forget = 0.0;

    static T plane_variance(T xx, T yy) { return larger<T>(0.5 * (xx + yy), splat<T>(1e-300)); }

    // The frame along the course and the scales of a scan: variances, and what things are divided by.
    struct View {
        T e[2], y[2], innovation[2], speed, measured, position, velocity, over_S, over_velocity, dt, sd[4];

        static T along(const T *e, T xx, T xy, T yy) { return larger<T>(e[0] * e[0] * xx + 2.0 * e[0] * e[1] * xy + e[1] * e[1] * yy, splat<T>(1e-300)); }
        static T root(T variance) { return variance * reciprocal_root<T>(variance); }

        View(const Seen<T> &o, const T *memory) {
            const T zero = splat<T>(0.0), one = splat<T>(1.0), vx = o.velocity.mean[0], vy = o.velocity.mean[1];
            speed = vx * vx + vy * vy;
            const Mask<T> moves = speed > zero;
            const T over = reciprocal_root<T>(select<T>(moves, speed, one));
            e[0] = select<T>(moves, vx * over, one), e[1] = select<T>(moves, vy * over, zero);
            const T side[2] = {-e[1], e[0]};
            const T *R = o.fix->P, *Pp = o.position.P, *Pv = o.velocity.P;
            const T Sxx = o.before.P[0] + R[0], Sxy = o.before.P[1] + R[1], Syy = o.before.P[2] + R[2];
            for (int a = 0; a < 2; ++a) innovation[a] = select<T>(o.taken, o.fix->p[a] - o.before.mean[a], zero);
            y[0] = (innovation[0] * e[0] + innovation[1] * e[1]) * reciprocal_root<T>(along(e, Sxx, Sxy, Syy));
            y[1] = (innovation[0] * side[0] + innovation[1] * side[1]) * reciprocal_root<T>(along(side, Sxx, Sxy, Syy));
            measured = plane_variance(R[0], R[2]), position = plane_variance(Pp[0], Pp[2]), velocity = plane_variance(Pv[0], Pv[2]);
            over_S = reciprocal_root<T>(plane_variance(Sxx, Syy)), over_velocity = reciprocal_root<T>(velocity);
            sd[0] = root(along(e, Pp[0], Pp[1], Pp[2])), sd[1] = root(along(side, Pp[0], Pp[1], Pp[2]));
            sd[2] = root(along(e, Pv[0], Pv[1], Pv[2])), sd[3] = root(along(side, Pv[0], Pv[1], Pv[2]));
            dt = o.time - memory[plane_time];
        }
    };

    // A track that begins has no past.
    void begin(const Seen<T> &o, T *memory) const {
        if (!any(o.begun)) return;
        for (int k = 0; k < plane_memory + 2 * kept; ++k) memory[k] = select<T>(o.begun, splat<T>(plane_begins(k)), memory[k]);
        memory[plane_time] = select<T>(o.begun, o.time, memory[plane_time]);
    }

    // The fading sums of innovations and averages, and what became of the correction before.
    void remember(const Seen<T> &o, const View &v, T *memory) const {
        const T over = v.over_S;
        T square = splat<T>(0.0), hit = square, size = square;
        for (int a = 0; a < 2; ++a) {
            const T n = v.innovation[a] * over, d = (memory[6 + a] + v.dt * memory[8 + a]) * over;
            memory[a] = select<T>(o.taken, plane_fast * memory[a] + n, memory[a]);
            memory[2 + a] = select<T>(o.taken, plane_slow * memory[2 + a] + n, memory[2 + a]);
            square = square + n * n, hit = hit + n * d, size = size + d * d;
        }
        memory[4] = select<T>(o.taken, memory[4] + plane_average * (smaller<T>(0.5 * square, splat<T>(plane_most)) - memory[4]), memory[4]);
        memory[5] = select<T>(o.taken, memory[5] + plane_average * (o.probability[0] - memory[5]), memory[5]);
        memory[plane_time] = select<T>(o.taken, o.time, memory[plane_time]);
        memory[11] = select<T>(o.taken, forget * memory[11] + hit, memory[11]);
        memory[12] = select<T>(o.taken, forget * memory[12] + size, memory[12]);
    }

    void inputs(const Seen<T> &o, const View &v, const T *memory, T *u, T *w) const {
        const int p = 0, q = shape.block, modes = (even - 12) / 2;
        const T *e = v.e, *Pv = o.velocity.P, tiny = splat<T>(1e-12);
        const auto log_of = [&](T x) { return logarithm<T>(larger<T>(x, tiny)); };
        const auto half_log = [&](T x) { return 0.5 * logarithm<T>(larger<T>(x, tiny * tiny)); };  // of a root
        const auto along = [&](T x, T y) { return x * e[0] + y * e[1]; };
        const auto across = [&](T x, T y) { return y * e[0] - x * e[1]; };
        const T over = v.over_velocity, time = View::root(v.position) * over, pull = time * over;  // of an acceleration, in the estimate's own units
        const T fast = splat<T>(std::sqrt(1.0 - plane_fast * plane_fast)), slow = splat<T>(std::sqrt(1.0 - plane_slow * plane_slow));
        int k = 0;
        u[k++] = v.y[0];
        u[k++] = along(o.after[p + 2], o.after[q + 2]) * pull;
        for (int j = 0; j < modes; ++j) u[k++] = o.probability[j];
        const T position = half_log(v.position), velocity = half_log(v.velocity), measured = half_log(v.measured), dt = log_of(v.dt);
        u[k++] = position - measured;
        u[k++] = dt - (position - velocity);
        u[k++] = smaller<T>(half_log(v.speed) - velocity, splat<T>(plane_fastest));
        u[k++] = ((e[0] * e[0] - e[1] * e[1]) * (Pv[0] - Pv[2]) + 4.0 * e[0] * e[1] * Pv[1]) * (0.5 * over * over);
        u[k++] = fast * along(memory[0], memory[1]);
        u[k++] = slow * along(memory[2], memory[3]);
        for (int j = 0; j < modes; ++j) u[k++] = o.prior[j];
        u[k++] = measured, u[k++] = dt, u[k++] = memory[4], u[k++] = memory[5];
        w[0] = v.y[1];
        w[1] = across(o.after[p + 2], o.after[q + 2]) * pull;
        w[2] = (e[0] * e[1] * (Pv[2] - Pv[0]) + (e[0] * e[0] - e[1] * e[1]) * Pv[1]) * (over * over);
        w[3] = shape.turn ? o.after[shape.n - 1] * time : splat<T>(0.0);
        w[4] = fast * across(memory[0], memory[1]);
        w[5] = slow * across(memory[2], memory[3]);
    }

    // An input within its range and scaled; `outside` is how far any was beyond it, in widths.
    S scaled(S x, const float *r, S &outside) const {
        const S low = splat<S>(r[0]), high = splat<S>(r[1]);
        outside = larger<S>(outside, larger<S>(low - x, x - high) * r[2]);
        return (larger<S>(smaller<S>(x, high), low) - r[3]) * r[4];
    }

    // The network's answers, which remembers a scan that was taken; returns how far they are believed.
    T answer(const Seen<T> &o, const T *u, const T *w, T *remembered, T *y) const {
        S outside = splat<S>(0.0), narrow[largest_layer + plane_kept], odd[plane_odd + plane_kept], said[plane_answers];
        const float *r = ranges.data();
        for (int k = 0; k < even; ++k, r += 5) narrow[k] = scaled(narrowed(u[k]), r, outside);
        for (int k = 0; k < plane_odd; ++k, r += 5) odd[k] = scaled(narrowed(w[k]), r, outside);
        for (int k = 0; k < kept; ++k) narrow[even + k] = narrowed(remembered[k]), odd[plane_odd + k] = narrowed(remembered[kept + k]);
        network(narrow, odd, said);
        for (int k = 0; k < kept; ++k) {
            remembered[k] = select<T>(o.taken, widened(narrow[even + k]), remembered[k]);
            remembered[kept + k] = select<T>(o.taken, widened(odd[plane_odd + k]), remembered[kept + k]);
        }
        for (int k = 0; k < plane_answers; ++k) y[k] = widened(said[k]);
        return widened(larger<S>(splat<S>(0.0), 1.0f - outside * over_fade));
    }

    T proved(const T *memory) const {
        return larger<T>(splat<T>(0.0), smaller<T>(splat<T>(1.0), (trust + memory[11]) * reciprocal<T>(trust + memory[12])));
    }
};

}  // namespace jink::inline JINK_LEVEL
