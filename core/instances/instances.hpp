// What is instantiated once per number type, in a translation unit of its own (step_*.cpp, smooth_*.cpp), and only named elsewhere.
// The lists are written once: JINK_STEP(extern, T) says "somewhere else", JINK_STEP(, T) "here".
#pragma once

#include "scan/aid.hpp"
#include "run/smooth.hpp"

#define JINK_STEP(WHERE, T)                                                                         \
    WHERE template Composition<T>::Composition(const Declaration &, Lift);                          \
    WHERE template void TrackState<T>::reset(const Composition<T> &);                               \
    WHERE template Proposal<T>::Proposal(const Composition<T> &);                                   \
    WHERE template Propagate<T>::Propagate(const Composition<T> &);                                 \
    WHERE template void Propagate<T>::elapse(T);                                                    \
    WHERE template void Propagate<T>::operator()(TrackState<T> &, T, const T *, const Fix<T> *);    \
    WHERE template void Propagate<T>::merge_pairs();                                                \
    WHERE template Step<T>::Step(const Composition<T> &);                                           \
    WHERE template Outcome<T> Step<T>::step(TrackState<T> &, const Scan<T> &, int);                 \
    WHERE template Combine<T>::Combine(const Composition<T> &);

#define JINK_AID(WHERE, T)                                                                                               \
    WHERE template Aid<T>::Aid(const Composition<T> &);                                                                  \
    WHERE template void Aid<T>::operator()(Step<T> &, TrackState<T> &, const Scan<T> &, const Outcome<T> &);             \
    WHERE template void record(const Step<T> &, const TrackState<T> &, const Scan<T> &, const Outcome<T> &, T, Record<T> &, Spare<T> &);

#define JINK_SMOOTH(WHERE, T)                                             \
    WHERE template Smooth<T>::Smooth(const Composition<T> &);             \
    WHERE template void Smooth<T>::last(const Record<T> &);               \
    WHERE template void Smooth<T>::last(const Record<T> &, Mask<T>);      \
    WHERE template void Smooth<T>::step(const Record<T> &, const Record<T> &);

namespace jink::inline JINK_LEVEL {
JINK_STEP(extern, double)
JINK_STEP(extern, Pack)
JINK_AID(extern, double)
JINK_AID(extern, Pack)
JINK_SMOOTH(extern, double)
JINK_SMOOTH(extern, Pack)
}  // namespace jink::inline JINK_LEVEL
