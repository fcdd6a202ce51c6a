// Geodesics of the WGS84 ellipsoid: by series in their length where they are short, on the auxiliary sphere where not.
//
// Angles in degrees at the border, in radians inside. The way of a geodesic is its parts east and north (m) in the meridian of a place.
// Sources: Torge, Müller, Geodesy, 4th edition, section 6.3, for the short; Karney, Journal of Geodesy 87, 2013, for the long.
#pragma once

#include "number/elementary.hpp"

namespace jink::inline JINK_LEVEL {

// Lengths in m.
struct Earth {
    static constexpr double equator = 6378137.0, flattening = 1.0 / 298.257223563;
    static constexpr double minor = equator * (1.0 - flattening);                            // half the axis of rotation, b
    static constexpr double polar = equator / (1.0 - flattening);                            // the radius of curvature at a pole, c
    static constexpr double second = 1.0 / ((1.0 - flattening) * (1.0 - flattening)) - 1.0;  // the second eccentricity squared, e'^2
    static constexpr double third = flattening / (2.0 - flattening);                         // the third flattening, n
};

// Short are geodesics below these lengths (m) that start nearer to the equator than these latitudes (degrees): the series err by less than
// 0.04 um there.
struct Short {
    static constexpr double between = 1e4, between_north = 80.0, ahead = 1e3, ahead_north = 75.0;
};

inline constexpr double degree = 3.14159265358979323846 / 180.0;

// Parts east and north in the meridian of the middle, and by how much the meridian turns on the way (rad).
template <class T> struct Leg {
    T east, north, turned;
    JINK_INLINE T length() const { return square_root(east * east + north * north); }
};

// Where a geodesic ends (degrees), and by how much the meridian turned on the way (rad).
template <class T> struct Arrival {
    T latitude, longitude, turned;
};

// The sum comes first, and rounds a difference to 3e-14 degrees: 3 nm.
template <class T> JINK_INLINE T wrapped_degrees(T angle) {
    constexpr double shift = 6755399441055744.0;
    const T shifted = angle + 180.0;
    const T turns = ((shifted - 180.0) * (1.0 / 360.0) + shift) - shift;
    return (shifted - turns * 360.0) - 180.0;
}

template <class T> JINK_INLINE T hypotenuse(T a, T b) { return square_root(a * a + b * b); }

// sin, cos, tan^2, eta^2 = e'^2 cos^2 and V^2 = 1 + eta^2 of a latitude (rad).
template <class T> struct Curvature {
    T sine, cosine, t2, eta, v2;
    explicit JINK_INLINE Curvature(T latitude) {
        sine_cosine<T>(latitude, sine, cosine);
        const T square = cosine * cosine;
        eta = Earth::second * square, v2 = 1.0 + eta;
        t2 = sine * sine / larger<T>(square, splat<T>(1e-30));
    }
};

// Gauss's mid-latitude formulas. With N = c / V and s, a the length and the direction at the middle,
//     s sin a = N dl cos (1 - dl^2 sin^2 / 24 + (1 + eta^2 - 9 eta^2 t^2) dp^2 / 24 V^4)
//     s cos a = N dp / V^2 (1 - (2 + 3 t^2 + 2 eta^2) dl^2 cos^2 / 24 + eta^2 (1 - t^2 + eta^2 + 4 eta^2 t^2) dp^2 / 8 V^4)
//     da      = dl sin (1 + (1 + eta^2) dl^2 cos^2 / 12 + (3 + 8 eta^2 + 5 eta^4) dp^2 / 24 V^4)
template <class T> JINK_INLINE Leg<T> short_between(T middle, T dphi, T dlam) {
    const Curvature<T> at(middle);
    const T n = Earth::polar / square_root(at.v2), over = 1.0 / at.v2, up = dphi * over, right = dlam * at.cosine, round = dlam * at.sine;
    const T square = up * up, east = right * right, eta = at.eta, t2 = at.t2;
    return {n * right * (1.0 + (square * (1.0 + eta - 9.0 * eta * t2) - round * round) * (1.0 / 24.0)),
            n * up * (1.0 - east * (2.0 + 3.0 * t2 + 2.0 * eta) * (1.0 / 24.0) + square * eta * (1.0 - t2 + eta + 4.0 * eta * t2) * 0.125),
            round * (1.0 + (1.0 + eta) * east * (1.0 / 12.0) + square * (3.0 + 8.0 * eta + 5.0 * eta * eta) * (1.0 / 24.0))};
}

// Legendre's series, with u, v the way north and east over N at the start:
//     dp = V^2 (u - 3 eta^2 t u^2 / 2 - t v^2 / 2 - (1 + 3 t^2 + eta^2 - 9 eta^2 t^2) u v^2 / 6 - eta^2 (1 - t^2 + eta^2 - 5 eta^2 t^2) u^3 / 2)
//     dl = (v + t u v - t^2 v^3 / 3 + (1 + 3 t^2 + eta^2) u^2 v / 3) / cos
//     da = t v + (1 + 2 t^2 + eta^2) u v / 2 - t (1 + 2 t^2 + eta^2) v^3 / 6 + t (5 + 6 t^2 + eta^2 - 4 eta^4) u^2 v / 6
template <class T> JINK_INLINE Arrival<T> short_ahead(T latitude, T longitude, T east, T north) {
    const Curvature<T> at(latitude * degree);
    const T over = square_root(at.v2) * (1.0 / Earth::polar), u = north * over, v = east * over, by_cosine = 1.0 / at.cosine;
    const T t = at.sine * by_cosine, t2 = at.t2, eta = at.eta, uv = u * v, uu = u * u, vv = v * v;
    const T round = 1.0 + 2.0 * t2 + eta, steep = 1.0 + 3.0 * t2 + eta;
    const T high = uv * v * (steep - 9.0 * eta * t2) * (1.0 / 6.0) + 0.5 * eta * uu * u * (1.0 - t2 + eta - 5.0 * eta * t2);
    const T bent = uu * (5.0 + 6.0 * t2 + eta - 4.0 * eta * eta) - vv * round;
    return {latitude + at.v2 * (u - t * (1.5 * eta * uu + 0.5 * vv) - high) * (1.0 / degree),
            longitude + (v + t * uv + v * (uu * steep - t2 * vv) * (1.0 / 3.0)) * by_cosine * (1.0 / degree),
            t * v + 0.5 * uv * round + t * v * bent * (1.0 / 6.0)};
}

// The reduced latitude b of a latitude p: tan b = (1 - f) tan p.
template <class T> struct Reduced {
    T sine, cosine;
    explicit JINK_INLINE Reduced(T latitude) {
        sine_cosine<T>(latitude, sine, cosine);
        sine = sine * (1.0 - Earth::flattening);
        const T over = 1.0 / hypotenuse<T>(sine, cosine);
        sine = sine * over, cosine = cosine * over;
    }
};

// Along the great circle of the auxiliary sphere that leaves the equator in the direction a0, s measured from there: the length on the
// ellipsoid is b A1 (s + sum C1_l sin 2 l s), the longitude that of the sphere less f sin a0 A3 (s + sum C3_l sin 2 l s).
// Karney's equations 15 to 18, 23 to 25, as far as a nanometre.
template <class T> struct GreatCircle {
    T k2, a1, c1[4], a3, c3[3];
    explicit JINK_INLINE GreatCircle(T cosine_a0) {
        constexpr double n = Earth::third;
        k2 = Earth::second * cosine_a0 * cosine_a0;
        const T e = k2 / (2.0 * (1.0 + square_root(1.0 + k2)) + k2), e2 = e * e;
        a1 = (1.0 + e2 * (0.25 + e2 * (1.0 / 64.0))) / (1.0 - e);
        c1[0] = e * (-0.5 + e2 * (3.0 / 16.0)), c1[1] = e2 * (-1.0 / 16.0 + e2 * (1.0 / 32.0));
        c1[2] = e * e2 * (-1.0 / 48.0), c1[3] = e2 * e2 * (-5.0 / 512.0);
        a3 = 1.0 - e * ((1.0 - n) / 2.0 + e * ((2.0 + n - 3.0 * n * n) / 8.0 + e * ((1.0 + 3.0 * n + n * n) / 16.0 + e * ((3.0 + 2.0 * n) / 64.0))));
        c3[0] = e * ((1.0 - n) / 4.0 + e * ((1.0 - n * n) / 8.0 + e * ((3.0 + 3.0 * n - n * n) / 64.0)));
        c3[1] = e2 * ((2.0 - 3.0 * n + n * n) / 32.0 + e * ((3.0 - 2.0 * n - 3.0 * n * n) / 64.0));
        c3[2] = e2 * e * ((5.0 - 9.0 * n + 5.0 * n * n) / 192.0);
    }
    // A (s2 - s1 + sum C_l (sin 2 l s2 - sin 2 l s1))
    template <int terms> static JINK_INLINE T integral(T a, const T (&c)[terms], T arc, T sine_1, T cosine_1, T sine_2, T cosine_2) {
        const auto waves = [&](T sine, T cosine) {
            const T twice = 2.0 - 4.0 * sine * sine;
            T before = splat<T>(0.0), now = 2.0 * sine * cosine, sum = c[0] * now;
            for (int l = 1; l < terms; ++l) {
                const T next = twice * now - before;
                before = now, now = next, sum = sum + c[l] * now;
            }
            return sum;
        };
        return a * (arc + (waves(sine_2, cosine_2) - waves(sine_1, cosine_1)));
    }
};

// The inverse problem, by iteration of the longitude on the sphere: each turn gains a factor of about f, less beyond 12,000 km.
template <class T> inline Leg<T> long_between(T latitude, T to_latitude, T dlam) {
    constexpr int turns = 8;
    const Reduced<T> one(latitude), other(to_latitude);
    T omega = dlam, length, start, end;
    for (int k = 0; k < turns; ++k) {
        T sine, cosine, sine_start, cosine_start, sine_1, cosine_1, sine_2, cosine_2;
        sine_cosine<T>(omega, sine, cosine);
        const T across = other.cosine * sine, along = one.cosine * other.sine - one.sine * other.cosine * cosine;
        const T arc = arc_tangent<T>(hypotenuse<T>(across, along), one.sine * other.sine + one.cosine * other.cosine * cosine);
        start = arc_tangent<T>(across, along);
        end = arc_tangent<T>(one.cosine * sine, one.cosine * other.sine * cosine - one.sine * other.cosine);
        sine_cosine<T>(start, sine_start, cosine_start);
        const T sine_a0 = sine_start * one.cosine, from = arc_tangent<T>(one.sine, cosine_start * one.cosine);
        const GreatCircle<T> circle(hypotenuse<T>(cosine_start, sine_start * one.sine));
        sine_cosine<T>(from, sine_1, cosine_1);
        sine_cosine<T>(from + arc, sine_2, cosine_2);
        length = Earth::minor * circle.integral(circle.a1, circle.c1, arc, sine_1, cosine_1, sine_2, cosine_2);
        omega = dlam + Earth::flattening * sine_a0 * circle.integral(circle.a3, circle.c3, arc, sine_1, cosine_1, sine_2, cosine_2);
    }
    const T turned = wrapped<T>(end - start);
    T sine, cosine;
    sine_cosine<T>(start + 0.5 * turned, sine, cosine);
    return {length * sine, length * cosine, turned};
}

// The direct problem: the arc by Newton's method, whose second turn is exact to rounding.
template <class T> inline Arrival<T> long_ahead(T latitude, T longitude, T east, T north) {
    const T length = hypotenuse<T>(east, north), sine_start = east / length, cosine_start = north / length;
    const Reduced<T> from(latitude * degree);
    const T sine_a0 = sine_start * from.cosine, cosine_a0 = hypotenuse<T>(cosine_start, sine_start * from.sine);
    const GreatCircle<T> circle(cosine_a0);
    const T begin = arc_tangent<T>(from.sine, cosine_start * from.cosine);
    T sine_1, cosine_1, sine_2, cosine_2, arc = length / (Earth::minor * circle.a1);
    sine_cosine<T>(begin, sine_1, cosine_1);
    for (int k = 0; k < 3; ++k) {
        sine_cosine<T>(begin + arc, sine_2, cosine_2);
        if (k == 2) break;
        const T off = circle.integral(circle.a1, circle.c1, arc, sine_1, cosine_1, sine_2, cosine_2) - length * (1.0 / Earth::minor);
        arc = arc - off / square_root(1.0 + circle.k2 * sine_2 * sine_2);
    }
    const T round = arc_tangent<T>(sine_a0 * sine_2, cosine_2) - arc_tangent<T>(sine_a0 * from.sine, cosine_start * from.cosine);
    const T turned_back = Earth::flattening * sine_a0 * circle.integral(circle.a3, circle.c3, arc, sine_1, cosine_1, sine_2, cosine_2);
    const T cosine_b = hypotenuse<T>(sine_a0, cosine_a0 * cosine_2);
    const T end = arc_tangent<T>(sine_a0, cosine_a0 * cosine_2);
    return {arc_tangent<T>(cosine_a0 * sine_2, (1.0 - Earth::flattening) * cosine_b) * (1.0 / degree),
            longitude + (round - turned_back) * (1.0 / degree), wrapped<T>(end - arc_tangent<T>(east, north))};
}

template <class T> inline Leg<T> geodesic_between(T latitude, T longitude, T to_latitude, T to_longitude) {
    const T dphi = (to_latitude - latitude) * degree, dlam = wrapped_degrees<T>(to_longitude - longitude) * degree, zero = splat<T>(0.0);
    Leg<T> leg = short_between<T>(0.5 * (latitude + to_latitude) * degree, dphi, dlam);
    Mask<T> far = magnitude(leg.east) + magnitude(leg.north) >= splat<T>(Short::between);
    far = (far | (magnitude(latitude) >= splat<T>(Short::between_north))) & ((dphi != zero) | (dlam != zero));
    if (!any(far)) return leg;
    const Leg<T> other = long_between<T>(latitude * degree, to_latitude * degree, dlam);
    return {select<T>(far, other.east, leg.east), select<T>(far, other.north, leg.north), select<T>(far, other.turned, leg.turned)};
}

template <class T> inline Arrival<T> geodesic_ahead(T latitude, T longitude, T east, T north) {
    const T size = magnitude(east) + magnitude(north), half = splat<T>(180.0);
    Arrival<T> place = short_ahead<T>(latitude, longitude, east, north);
    const Mask<T> far = ((size >= splat<T>(Short::ahead)) | (magnitude(latitude) >= splat<T>(Short::ahead_north))) & (size > splat<T>(0.0));
    if (any(far)) {
        const Arrival<T> other = long_ahead<T>(latitude, longitude, east, north);
        place.latitude = select<T>(far, other.latitude, place.latitude), place.longitude = select<T>(far, other.longitude, place.longitude);
        place.turned = select<T>(far, other.turned, place.turned);
    }
    place.longitude = select<T>(magnitude(place.longitude) > half, wrapped_degrees<T>(place.longitude), place.longitude);
    return place;
}

}  // namespace jink::inline JINK_LEVEL
