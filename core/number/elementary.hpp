// exp, log, sin, cos and atan2 for every number type, by the same arithmetic in each, so that one lane equals one scalar.
//
// Accuracy: a few units in the last place over the ranges the filters use; NaN in, NaN out.
// The logarithm's and the sine's polynomials are those of FDLIBM, the arc tangent's rational that of Cephes.
#pragma once

#include "number/number.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> JINK_INLINE T exponential(T x) {
    // x = k ln2 + r, |r| <= ln2 / 2; e^r by its series to degree 13 (4e-18)
    constexpr double shift = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to an integer held in the low bits
    const T clipped = larger<T>(smaller<T>(x, splat<T>(709.0)), splat<T>(-708.0));
    const T shifted = clipped * 1.4426950408889634 + shift;
    const T k = shifted - shift;
    const T r = (clipped - k * 6.93147180369123816490e-01) - k * 1.90821492927058770002e-10;
    T p = splat<T>(1.0 / 6227020800.0);
    p = p * r + 1.0 / 479001600.0;
    p = p * r + 1.0 / 39916800.0;
    p = p * r + 1.0 / 3628800.0;
    p = p * r + 1.0 / 362880.0;
    p = p * r + 1.0 / 40320.0;
    p = p * r + 1.0 / 5040.0;
    p = p * r + 1.0 / 720.0;
    p = p * r + 1.0 / 120.0;
    p = p * r + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    p = p * r + 1.0;
    p = p * r + 1.0;
    const T power = from_bits<T>((to_bits(shifted) << 52) + to_bits(splat<T>(1.0)));
    const T result = select<T>(x < splat<T>(-708.0), splat<T>(0.0), p * power);
    return select<T>(is_nan(x), x, result);
}

// e^x - 1 without cancellation: its series to degree 15 for |x| < 1/2.
template <class T> inline T exponential_less_one(T x) {
    const Mask<T> small = magnitude(x) < splat<T>(0.5);
    const T near = select<T>(small, x, splat<T>(0.0));
    T p = splat<T>(1.0);
    for (int k = 15; k >= 2; --k) p = 1.0 + p * near * (1.0 / k);
    return select<T>(small, near * p, exponential<T>(x) - 1.0);
}

template <class T> JINK_INLINE T logarithm(T x) {
    constexpr std::int64_t root_half = 0x3fe6a09e667f3bcd;  // bits of sqrt(1/2): the mantissa's range is [sqrt(1/2), sqrt(2))
    const Bits<T> bits = to_bits(x);
    const Bits<T> exponent = (bits - root_half) >> 52;
    const T m = from_bits<T>(bits - (exponent << 52));
    // the exponent as a number, without an integer conversion instruction
    const T k = from_bits<T>(exponent + std::int64_t(0x4338000000000000)) - 6755399441055744.0;
    const T f = m - 1.0;
    const T s = f / (m + 1.0);
    const T z = s * s;
    T p = splat<T>(1.479819860511658591e-01);
    p = p * z + 1.531383769920937332e-01;
    p = p * z + 1.818357216161805012e-01;
    p = p * z + 2.222219843214978396e-01;
    p = p * z + 2.857142874366239149e-01;
    p = p * z + 3.999999999940941908e-01;
    p = p * z + 6.666666666666735130e-01;
    const T half_square = 0.5 * f * f;
    const T rest = s * (half_square + z * p) + k * 1.90821492927058770002e-10;
    const T result = k * 6.93147180369123816490e-01 - ((half_square - rest) - f);
    const T infinity = splat<T>(std::numeric_limits<double>::infinity());
    const T edge = select<T>(x == splat<T>(0.0), -infinity, nan_of<T>());
    return select<T>((x > splat<T>(0.0)) & (x < infinity), result, select<T>(x == infinity, x, edge));
}

// Sine and cosine together. Beyond |x| = 1e5 the quick reduction would lose digits, so those are first reduced exactly.
template <class T> JINK_INLINE void sine_cosine(T x, T &sine, T &cosine) {
    constexpr double shift = 6755399441055744.0;
    T a = x;
    if (any(magnitude(x) > splat<T>(1e5)))
        for (int l = 0; l < width<T>; ++l) set_lane(a, l, std::remainder(lane(x, l), 6.283185307179586476925));
    const T shifted = a * 0.63661977236758134308 + shift;
    const T k = shifted - shift;
    T r = a - k * 1.57079632673412561417e+00;
    r = r - k * 6.07710050630396597660e-11;
    r = r - k * 2.02226624879595063154e-21;
    const T z = r * r;
    T s = splat<T>(1.58969099521155010221e-10);
    s = s * z - 2.50507602534068634195e-08;
    s = s * z + 2.75573137070700676789e-06;
    s = s * z - 1.98412698298579493134e-04;
    s = s * z + 8.33333333332248946124e-03;
    s = s * z - 1.66666666666666324348e-01;
    s = r + r * z * s;
    T c = splat<T>(-1.13596475577881948265e-11);
    c = c * z + 2.08757232129817482790e-09;
    c = c * z - 2.75573143513906633035e-07;
    c = c * z + 2.48015872894767294178e-05;
    c = c * z - 1.38888888888741095749e-03;
    c = c * z + 4.16666666666666019037e-02;
    c = (1.0 - 0.5 * z) + z * z * c;
    const Bits<T> quadrant = to_bits(shifted);
    const Bits<T> zero = quadrant & std::int64_t(0);
    const Mask<T> swap = (quadrant & std::int64_t(1)) != zero;
    const T s_turned = select<T>(swap, c, s), c_turned = select<T>(swap, s, c);
    sine = select<T>((quadrant & std::int64_t(2)) != zero, -s_turned, s_turned);
    cosine = select<T>(((quadrant + std::int64_t(1)) & std::int64_t(2)) != zero, -c_turned, c_turned);
}

template <class T> JINK_INLINE T arc_tangent(T y, T x) {
    constexpr double pi = 3.14159265358979323846;
    const T ax = magnitude(x), ay = magnitude(y);
    const T big = larger<T>(ax, ay), small = smaller<T>(ax, ay);
    const T ratio = select<T>(big == splat<T>(0.0), splat<T>(0.0), small / big);
    const Mask<T> upper = ratio > splat<T>(0.66);
    const T a = select<T>(upper, (ratio - 1.0) / (ratio + 1.0), ratio);
    const T z = a * a;
    T p = splat<T>(-8.750608600031904122785e-01);
    p = p * z - 1.615753718733365076637e+01;
    p = p * z - 7.500855792314704667340e+01;
    p = p * z - 1.228866684490136173410e+02;
    p = p * z - 6.485021904942025371773e+01;
    T q = z + 2.485846490142306297962e+01;
    q = q * z + 1.650270098316988542046e+02;
    q = q * z + 4.328810604912902668951e+02;
    q = q * z + 4.853903996359136964868e+02;
    q = q * z + 1.945506571482613964425e+02;
    T angle = a + a * z * (p / q);
    angle = select<T>(upper, angle + pi / 4, angle);
    angle = select<T>(ay > ax, pi / 2 - angle, angle);
    angle = select<T>(x < splat<T>(0.0), pi - angle, angle);
    angle = select<T>(y < splat<T>(0.0), -angle, angle);
    return select<T>(is_nan(x) | is_nan(y), x + y, angle);
}

// The angle's representative in [-pi, pi].
template <class T> JINK_INLINE T wrapped(T angle) {
    constexpr double shift = 6755399441055744.0, two_pi = 6.283185307179586476925;
    const T turns = (angle * (1.0 / two_pi) + shift) - shift;
    return angle - turns * two_pi;
}

// The normal distribution function; lane by lane, since it is asked for only with the probability integral transform.
template <class T> inline T normal_cdf(T x) {
    T result = x;
    for (int l = 0; l < width<T>; ++l) set_lane(result, l, 0.5 * std::erfc(-lane(x, l) * 0.70710678118654752440));
    return result;
}

}  // namespace jink::inline JINK_LEVEL
