// A number with exact derivatives: a value and its slopes along K directions, by the chain rule.
//
//   (a, a')(b, b') = (ab, a'b + ab'),   f((a, a')) = (f(a), f'(a) a')
//
// Everything number.hpp and elementary.hpp offer, so that what is differentiated is what runs. Branches look at values alone:
// where a filter switches (gates, restarts), the derivative is that of the branch taken.
// Forward mode: Griewank & Walther, Evaluating Derivatives, 2008, chapter 3.
#pragma once

#include <concepts>
#include <utility>

#include "number/elementary.hpp"

namespace jink::inline JINK_LEVEL {

template <class V, int K> struct Dual {
    V value;
    V slope[K];

    static constexpr int slopes = K;

    // f(a), slope by slope.
    template <class Chain> static JINK_INLINE Dual of(V value, Chain chain) {
        Dual out;
        out.value = value;
        for (int k = 0; k < K; ++k) out.slope[k] = chain(k);
        return out;
    }

    friend JINK_INLINE Dual operator+(Dual a, Dual b) {
        return of(a.value + b.value, [&](int k) { return a.slope[k] + b.slope[k]; });
    }
    friend JINK_INLINE Dual operator-(Dual a, Dual b) {
        return of(a.value - b.value, [&](int k) { return a.slope[k] - b.slope[k]; });
    }
    friend JINK_INLINE Dual operator*(Dual a, Dual b) {
        return of(a.value * b.value, [&](int k) { return a.slope[k] * b.value + a.value * b.slope[k]; });
    }
    friend JINK_INLINE Dual operator/(Dual a, Dual b) {
        const V over = 1.0 / b.value, ratio = a.value * over;
        return of(ratio, [&](int k) { return (a.slope[k] - ratio * b.slope[k]) * over; });
    }
    friend JINK_INLINE Dual operator-(Dual a) {
        return of(-a.value, [&](int k) { return -a.slope[k]; });
    }

    friend JINK_INLINE Dual operator+(Dual a, double b) { return a.value = a.value + b, a; }
    friend JINK_INLINE Dual operator+(double a, Dual b) { return b.value = a + b.value, b; }
    friend JINK_INLINE Dual operator-(Dual a, double b) { return a.value = a.value - b, a; }
    friend JINK_INLINE Dual operator-(double a, Dual b) {
        return of(a - b.value, [&](int k) { return -b.slope[k]; });
    }
    friend JINK_INLINE Dual operator*(Dual a, double b) {
        return of(a.value * b, [&](int k) { return a.slope[k] * b; });
    }
    friend JINK_INLINE Dual operator*(double a, Dual b) { return b * a; }
    friend JINK_INLINE Dual operator/(double a, Dual b) {
        const V over = 1.0 / b.value, ratio = a * over, back = -ratio * over;
        return of(ratio, [&](int k) { return back * b.slope[k]; });
    }

    friend JINK_INLINE auto operator<(Dual a, Dual b) { return a.value < b.value; }
    friend JINK_INLINE auto operator>(Dual a, Dual b) { return a.value > b.value; }
    friend JINK_INLINE auto operator<=(Dual a, Dual b) { return a.value <= b.value; }
    friend JINK_INLINE auto operator>=(Dual a, Dual b) { return a.value >= b.value; }
    friend JINK_INLINE auto operator==(Dual a, Dual b) { return a.value == b.value; }
    friend JINK_INLINE auto operator!=(Dual a, Dual b) { return a.value != b.value; }
};

template <class V, int K> struct NumberTraits<Dual<V, K>> : NumberTraits<V> {};
template <class T>
concept WithSlopes = std::same_as<T, Dual<decltype(T::value), T::slopes>>;

// The number without its slopes.
template <class T> JINK_INLINE auto &value_of(T &x) {
    if constexpr (WithSlopes<std::remove_const_t<T>>) return x.value;
    else return x;
}
template <class T> using Value = std::remove_cvref_t<decltype(value_of(std::declval<T &>()))>;

template <WithSlopes T> inline bool without_slopes(const T *x, int n) {
    Mask<T> found = splat_mask<T>(false);
    for (int i = 0; i < n; ++i)
        for (const auto &slope : x[i].slope) found = found | (slope != splat<decltype(T::value)>(0.0));
    return !any(found);
}

// f(a) with f'(a) times each slope.
template <WithSlopes T, class V> JINK_INLINE T chained(T a, V value, V derivative) {
    return T::of(value, [&](int k) { return derivative * a.slope[k]; });
}

template <WithSlopes T> JINK_INLINE T select(Mask<T> mask, T yes, T no) {
    return T::of(mask ? yes.value : no.value, [&](int k) { return mask ? yes.slope[k] : no.slope[k]; });
}
template <WithSlopes T> JINK_INLINE double lane(T x, int l) { return lane(x.value, l); }
template <WithSlopes T> JINK_INLINE void set_lane(T &x, int l, double to) {
    set_lane(x.value, l, to);
    for (auto &slope : x.slope) set_lane(slope, l, 0.0);
}

template <WithSlopes T> JINK_INLINE T reciprocal(T x) {
    const auto y = reciprocal(x.value);
    return chained(x, y, -y * y);
}
template <WithSlopes T> JINK_INLINE T reciprocal_root(T x) {
    const auto y = reciprocal_root(x.value);
    return chained(x, y, -0.5 * y * y * y);
}
template <WithSlopes T> JINK_INLINE T square_root(T x) {
    const auto root = square_root(x.value);
    return chained(x, root, 0.5 / root);
}
template <WithSlopes T> JINK_INLINE T magnitude(T x) {
    return select<T>(x.value < splat<decltype(x.value)>(0.0), -x, x);
}
template <WithSlopes T> inline T exponential(T x) {
    const auto y = exponential<decltype(x.value)>(x.value);
    return chained(x, y, y);
}
template <WithSlopes T> inline T logarithm(T x) {
    return chained(x, logarithm<decltype(x.value)>(x.value), 1.0 / x.value);
}
template <WithSlopes T> inline void sine_cosine(T x, T &sine, T &cosine) {
    auto s = x.value, c = s;
    sine_cosine<decltype(x.value)>(x.value, s, c);
    sine = chained(x, s, c), cosine = chained(x, c, -s);
}
template <WithSlopes T> inline T arc_tangent(T y, T x) {
    const auto over = 1.0 / (x.value * x.value + y.value * y.value);
    return T::of(arc_tangent<decltype(x.value)>(y.value, x.value),
                 [&](int k) { return (x.value * y.slope[k] - y.value * x.slope[k]) * over; });
}
template <WithSlopes T> JINK_INLINE T wrapped(T angle) {
    angle.value = wrapped<decltype(angle.value)>(angle.value);
    return angle;
}
template <WithSlopes T> inline T normal_cdf(T x) {
    using V = decltype(x.value);
    return chained(x, normal_cdf<V>(x.value), exponential<V>(-0.5 * x.value * x.value) * 0.39894228040143267794);
}

}  // namespace jink::inline JINK_LEVEL
