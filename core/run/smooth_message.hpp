// What the smoother of several modes passes from scan to scan, and the table of its arithmetic (smooth_kernels.hpp).
//
// Modes of different kinds have positions and velocities in common, and nothing else. A pair of such modes is fused in these alone.
// So they come first in a passage's J, in a pair's h and J and in a factor: the order of smooth_roots.hpp. The rest is as in the state.
//
// A message is log p(Z_future | x) = s + h' e - 1/2 e' J e with e = x - x_0, or, with J = R R' (R lower triangular) and h = R g,
//
//   s + 1/2 g' g - 1/2 |g - R' e|^2
#pragma once

#include "number/matrix.hpp"
#include "scan/composition.hpp"

namespace jink::inline JINK_LEVEL {

inline constexpr int most_entering = 4;

// These times a number is infinite where a state, or a variance, is beyond what a place can be (`farthest`).
inline constexpr double to_farthest = 1.79e308 / farthest, to_least_certain = to_farthest / farthest;

// A message as it is kept from scan to scan, and as s - 1/2 |g - R' e|^2. `rest` is a factor beside exp(s), which spares logarithms.
// J may be the rest of one that was `grown` times as large, and has its rounding.
template <class T> struct Message {
    T J[packed_size(largest_state)], h[largest_state], s, rest, grown;
};
template <class T> struct MessageRoot {
    T R[packed_size(largest_state)], g[largest_state], s, rest;
};

// A message through the motion from the scan before: |c - B e|^2 with e in the states before, about `start`, and J = B' B, of what
// both modes have. `v` and `scale` are of the components that enter (enter below).
template <class T> struct Passage {
    T B[largest_state * largest_state], J[packed_size(largest_state)], v[most_entering * largest_state], scale[most_entering], s, rest;
    T start[largest_state], c[largest_state];
    MessageRoot<T> own;  // where its noise depends on the state
    const MessageRoot<T> *root;
};

// A mode before and a mode after: their message to the mode before, and the two fused.
template <class T> struct SmoothPair {
    T x[largest_state], P[packed_size(largest_state)], h[largest_state], log_weight, share;
    const T *J;  // its passage's
    bool whole;  // both modes have the same components
};

// A positive number as exp(log) * rest, with 1 <= rest < 2 and a log that is a multiple of log 2: quicker than a logarithm.
template <class T> struct Scaled {
    T log, rest;
};
template <class T> JINK_INLINE Scaled<T> scaled(T x) {
    const Bits<T> exponent = (to_bits(x) >> 52) - std::int64_t(1023);
    const T rest = from_bits<T>(to_bits(x) - (exponent << 52));
    const T k = from_bits<T>(exponent + std::int64_t(0x4338000000000000)) - 6755399441055744.0;
    return {k * 0.693147180559945309417, rest};
}

// What there is twice is of the components that modes of all kinds have, and of the whole state.
template <class T> struct SmoothKernels {
    // P = L L'.
    void (*factor)(const T *P, T *L);
    // J = R R' of a semidefinite J, and h = R g; s follows.
    void (*root)(const Message<T> &m, MessageRoot<T> &to);
    // The message before noise of covariance Q.
    void (*blur)(const T *Q, MessageRoot<T> &m);
    // The same for noise of covariance V V', V column after column; J and h of the result.
    void (*spread)(const T *V, int columns, MessageRoot<T> &m, T *J, T *h);
    // The same from J and h to J and h, column by column: J <- J - J v v' J / (1 + v' J v). Quicker, but digits are lost where
    // v' J v is large. Returns the product of all 1 + v' J v: no element of the diagonal shrinks by more.
    T (*thin)(const T *V, int columns, T *J, T *h);
    // J = B' B.
    void (*gram[2])(const T *B, T *J);
    // B = R' F for a full F.
    void (*pull)(const T *R, const T *F, T *B);
    // B <- (I + v v')^-1/2 B = (I - scale v v') B, as the component enters that is number `entered` of those not shared. Returns
    // (1 + v' v)^-1/2.
    T (*enter)(const T *v, int entered, T *B, T &scale);
    // c about the state that the passage starts from, which moves to `ahead`; `entering` times B's turn is done to it as well.
    void (*listen)(const T *ahead, const T *x, int entering, Passage<T> &by);
    // h of the message about another start (or null), and its s: c is linear in the start.
    T (*hear[2])(const Passage<T> &by, const T *start, T *h);
    // Of N(x, L L') and the message: mean and, unless null, covariance of their product, and the message's mean under the former.
    Scaled<T> (*fuse[2])(const T *L, const T *J, const T *h, const T *x, T *to, T *P);
    // That mean alone, of a mode's own message.
    Scaled<T> (*level)(const T *L, const T *J, const T *h);
    // Moments of a mode over its pairs, by their shares (P unless null), and their mean message. V gets the spread of the pairs about
    // the mean, count - 1 columns.
    void (*merge)(const SmoothPair<T> *pairs, int count, T *x, T *P, T *J, T *h, T *V);
    // 0, or NaN where a number is beyond the range of numbers, or a state or variance beyond what a place can be. P may be null.
    T (*unsound)(const T *x, const T *P, const Message<T> &m);
};

// For the states of a shape; `full` where the noise couples all components.
template <class T> SmoothKernels<T> smooth_kernels(const StateShape &shape, bool full);

}  // namespace jink::inline JINK_LEVEL
