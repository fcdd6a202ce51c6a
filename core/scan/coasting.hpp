// What a target does while nothing is measured: it ceases to manoeuvre and to climb, and most targets do not go backwards.
//
// After `after` seconds without an accepted measurement accelerations and turn rates die away with one time constant, climb rates
// with another. A target that brakes stops where its velocity would turn about. Means alone change, as by a known input:
// covariances grow as the motion models say, and so do the smoothers' gains.
#pragma once

#include "models/motion_turn.hpp"
#include "scan/track.hpp"

namespace jink::inline JINK_LEVEL {

// How much of a step lies beyond the time after which a target is said to coast, in the plane and upwards.
template <class T> struct Coasted {
    T plane, height;
};

template <class T> class Coast {
  public:
    explicit Coast(const CoastDeclaration &declared) : d(declared) {}

    bool active() const { return d.active(); }

    // Where a mode's prediction is not the motion model's alone, which is linear in x.
    Mask<T> bends(const Mode<T> &mode, const Coasted<T> &late) const {
        if (!active()) return splat_mask<T>(false);
        const bool stops = mode.motion.kind == MotionKind::constant_acceleration && !d.reverses;
        return stops ? splat_mask<T>(true) : (late.plane > splat<T>(0.0)) | (late.height > splat<T>(0.0));
    }

    Coasted<T> over(const TrackState<T> &s, T dt) const {
        return {share(s, s.time + dt - s.last_accepted, dt), share(s, s.time + dt - s.last_height, dt)};
    }

    // Of a mode, from `x` to its prediction `y` after dt.
    void operator()(const Mode<T> &mode, T dt, const Coasted<T> &late, const T *x, T *y) const {
        const StateShape &shape = mode.shape;
        const MotionKind kind = mode.motion.kind;
        const bool accelerates = kind == MotionKind::constant_acceleration;
        if (kind == MotionKind::coordinated_turn) turn(dt, late.plane, x, y, shape.n - 1);
        for (int a = 0; a < shape.axes && accelerates; ++a) ease(dt, a == 2 ? late.height : late.plane, x + 3 * a, y + 3 * a);
        if (accelerates && !d.reverses && shape.axes > 1) stop(shape.axes, x, y);
        if (shape.axes == 3 && (accelerates || shape.block == 2)) level(late.height, y + 2 * shape.block);
    }

  private:
    CoastDeclaration d;

    T share(const TrackState<T> &s, T age, T dt) const {
        if (!(d.after > 0.0)) return splat<T>(0.0);
        const T beyond = smaller<T>(age - d.after, dt);
        return select<T>(s.running & (beyond > splat<T>(0.0)), beyond, splat<T>(0.0));
    }

    // One axis of constant acceleration, [p v a]: as it was until it coasts, then a' = -a / time.
    void ease(T dt, T late, const T *x, T *y) const {
        const Mask<T> on = late > splat<T>(0.0);
        if (!any(on)) return;
        const T early = dt - late, kept = exponential<T>(late * (-1.0 / d.manoeuvre)), pull = d.manoeuvre * (1.0 - kept);
        const T v = x[1] + early * x[2];
        const T p = x[0] + early * x[1] + 0.5 * early * early * x[2];
        y[0] = select<T>(on, p + late * v + d.manoeuvre * (late - pull) * x[2], y[0]);
        y[1] = select<T>(on, v + pull * x[2], y[1]);
        y[2] = select<T>(on, kept * x[2], y[2]);
    }

    // A turn whose rate dies away, along the chord of a steady turn by the same angle.
    void turn(T dt, T late, const T *x, T *y, int rate) const {
        const Mask<T> on = late > splat<T>(0.0);
        if (!any(on)) return;
        const T kept = exponential<T>(late * (-1.0 / d.manoeuvre));
        const TurnFunctions<T> t(x[rate] * (dt - late + d.manoeuvre * (1.0 - kept)));
        y[0] = select<T>(on, x[0] + dt * (t.s * x[1] - t.c * x[3]), y[0]);
        y[1] = select<T>(on, t.cosine * x[1] - t.sine * x[3], y[1]);
        y[2] = select<T>(on, x[2] + dt * (t.c * x[1] + t.s * x[3]), y[2]);
        y[3] = select<T>(on, t.sine * x[1] + t.cosine * x[3], y[3]);
        y[rate] = select<T>(on, kept * x[rate], y[rate]);
    }

    // A target that brakes stands still from where its velocity would point backwards.
    void stop(int axes, const T *x, T *y) const {
        const T zero = splat<T>(0.0);
        const Mask<T> back = x[1] * y[1] + x[4] * y[4] < zero;
        if (!any(back)) return;
        const T brake = select<T>(back, -(x[1] * x[2] + x[4] * x[5]), splat<T>(1.0));
        const T until = (x[1] * x[1] + x[4] * x[4]) / brake;
        for (int k = 0; k < 6 && axes > 1; k += 3) {
            y[k] = select<T>(back, x[k] + until * x[k + 1] + 0.5 * until * until * x[k + 2], y[k]);
            y[k + 1] = select<T>(back, zero, y[k + 1]), y[k + 2] = select<T>(back, zero, y[k + 2]);
        }
    }

    // The vertical axis, [p v ...]: its velocity dies away.
    void level(T late, T *y) const {
        const Mask<T> on = late > splat<T>(0.0);
        if (!any(on)) return;
        const T kept = exponential<T>(late * (-1.0 / d.climb)), climb = d.climb * (1.0 - kept);
        y[0] = select<T>(on, y[0] + (climb - late) * y[1], y[0]);
        y[1] = select<T>(on, kept * y[1], y[1]);
    }
};

}  // namespace jink::inline JINK_LEVEL
