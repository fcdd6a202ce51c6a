// Which kernel belongs to which motion model; included by the one translation unit per number type that instantiates them.
#pragma once

#include "models/motion_acceleration.hpp"
#include "models/motion_turn.hpp"
#include "scan/predict.hpp"

namespace jink::inline JINK_LEVEL {

template <class T, int A> MotionKernels<T> kernels_for_axes(const MotionSpec &spec, bool unscented) {
    switch (spec.kind) {
        case MotionKind::constant_velocity: return kernels_of<T, ConstantVelocity<A>>(spec, unscented);
        case MotionKind::constant_acceleration:
        case MotionKind::singer: return kernels_of<T, AccelerationState<A>>(spec, unscented);
        case MotionKind::current_statistical: return kernels_of<T, CurrentStatistical<A>>(spec, unscented);
        case MotionKind::statistical_along_track: return kernels_of<T, AlongTrack<CurrentStatistical<A>>>(spec, unscented);
        case MotionKind::velocity_along_track: return kernels_of<T, AlongTrack<ConstantVelocity<A>>>(spec, unscented);
        case MotionKind::augmented: return kernels_of<T, Augmented<A, false>>(spec, unscented);
        case MotionKind::two_stage: return kernels_of<T, Augmented<A, true>>(spec, unscented);
        default: break;
    }
    if constexpr (A >= 2) {
        if (spec.kind == MotionKind::known_turn) return kernels_of<T, KnownTurn<A>>(spec, unscented);
        return kernels_of<T, CoordinatedTurn<A>>(spec, unscented);
    }
    return {};
}

template <class T> MotionKernels<T> motion_kernels(const MotionSpec &spec, bool unscented) {
    if (spec.axes == 1) return kernels_for_axes<T, 1>(spec, unscented);
    if (spec.axes == 2) return kernels_for_axes<T, 2>(spec, unscented);
    return kernels_for_axes<T, 3>(spec, unscented);
}

}  // namespace jink::inline JINK_LEVEL
